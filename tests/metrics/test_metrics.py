"""Every measure: ideal on equal models, planted values, an independent computation, and invariances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import meshmark as mm
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.metrics import METRICS, compare

BOX = Mesh(
    np.array([[x, y, z] for x in (0.0, 2.0) for y in (0.0, 3.0) for z in (0.0, 6.0)]), np.array([[0, 1, 2]])
)  # diagonal 7, longest side 6


def moved(by: float, vertices: int = 8) -> Mesh:
    """Return the box with the first vertices moved along z."""
    positions = BOX.vertices.copy()
    positions[:vertices, 2] += by
    return BOX.with_vertices(positions)


def test_planted_values():
    result = compare(BOX, moved(0.07))
    assert result.rms_over_diagonal == pytest.approx(0.01, rel=1e-12)
    assert result.max_over_diagonal == pytest.approx(0.01, rel=1e-12)
    assert result.psnr_db == pytest.approx(40.0, abs=1e-9)
    assert result.paper_psnr_db == pytest.approx(-20 * math.log10(0.07 / 6), abs=1e-9)
    half = compare(BOX, moved(0.07, vertices=4))
    assert half.rms_over_diagonal == pytest.approx(0.01 / math.sqrt(2), rel=1e-12)
    assert half.max_over_diagonal == pytest.approx(0.01, rel=1e-12)


def test_the_paper_s_formula_on_a_unit_model_with_a_maximum_of_1():
    unit = BOX.with_vertices(BOX.vertices / 6.0)
    random = np.random.default_rng(0)
    other = unit.with_vertices(unit.vertices + random.normal(scale=1e-3, size=(8, 3)))
    mean_square = np.square(other.vertices - unit.vertices).sum(axis=1).mean()
    assert METRICS["paper_psnr_db"](unit, other) == pytest.approx(
        10 * math.log10(1.0 / mean_square), abs=1e-9
    )


@pytest.mark.parametrize("name", METRICS)
def test_ideal_on_equal_models_and_worse_the_further_they_are(name):
    metric = METRICS[name]
    ideal = metric(BOX, BOX)
    assert ideal == (metric.limits[0] if metric.better == "lower" else metric.limits[1])
    values = [metric(BOX, moved(by)) for by in (0.001, 0.01, 0.1)]
    assert values == sorted(values, reverse=metric.better == "higher")
    assert all(metric.limits[0] <= value <= metric.limits[1] for value in values)


@pytest.mark.parametrize("name", METRICS)
@given(seed=st.integers(0, 2**32 - 1), scale=st.floats(1e-6, 1e6))
def test_scaling_both_models_changes_nothing(name, seed, scale):
    random = np.random.default_rng(seed)
    a = BOX.with_vertices(random.normal(size=(8, 3)))
    b = BOX.with_vertices(a.vertices + 0.01 * random.normal(size=(8, 3)))
    grown = METRICS[name](a.with_vertices(scale * a.vertices), b.with_vertices(scale * b.vertices))
    assert grown == pytest.approx(METRICS[name](a, b), rel=1e-9)


@given(seed=st.integers(0, 2**32 - 1))
def test_the_distances_do_not_depend_on_the_axes(seed):
    random = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed).as_matrix()
    a, b = random.normal(size=(2, 8, 3))
    plain = METRICS["max_over_diagonal"](BOX.with_vertices(a), BOX.with_vertices(b))
    sizes = [np.linalg.norm(np.ptp(v, axis=0)) for v in (a, a @ turn)]
    turned = METRICS["max_over_diagonal"](BOX.with_vertices(a @ turn), BOX.with_vertices(b @ turn))
    assert turned * sizes[1] == pytest.approx(plain * sizes[0], rel=1e-9)


@pytest.mark.parametrize("name", METRICS)
def test_what_cannot_be_compared_is_refused(name):
    fewer = Mesh(BOX.vertices[:7], BOX.faces)
    point = Mesh(np.ones((8, 3)), BOX.faces)
    nothing = Mesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    for a, b in ((BOX, fewer), (point, BOX), (nothing, nothing)):
        with pytest.raises(InputError):
            METRICS[name](a, b)


def test_compare_gives_every_metric_of_the_table():
    other = moved(0.01, vertices=3)
    result = compare(BOX, other).to_dict()
    assert {name: result[name] for name in METRICS} == {
        name: metric(BOX, other) for name, metric in METRICS.items()
    }


def test_compare_of_other_counts_or_equal_models_is_none_in_json():
    assert set(compare(BOX, Mesh(BOX.vertices[:7], BOX.faces)).to_dict().values()) == {None}
    equal = compare(BOX, BOX)
    assert equal.psnr_db == math.inf
    assert equal.to_dict()["psnr_db"] is None
    assert equal.to_dict()["rms_over_diagonal"] == 0.0


def test_inputs_stay_as_they_are():
    a, b = BOX.vertices.copy(), moved(0.1).vertices.copy()
    mm.compare(Mesh(a, BOX.faces), Mesh(b, BOX.faces))
    assert np.array_equal(a, BOX.vertices)
    assert np.array_equal(b, moved(0.1).vertices)
