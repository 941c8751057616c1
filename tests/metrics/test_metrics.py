"""The table: every measure is ideal on equal things, worse the further they are, and in the range it names."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import meshmark as mm
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.metrics import METRICS, compare, surface_distance
from tests.counting import some
from tests.shapes import pebble

BOX = Mesh(
    np.array([[x, y, z] for x in (0.0, 2.0) for y in (0.0, 3.0) for z in (0.0, 6.0)]), np.array([[0, 1, 2]])
)  # diagonal 7, longest side 6
MODEL = Mesh(*pebble(24))
NOISE = np.random.default_rng(5).normal(size=MODEL.vertices.shape)
OF_MESHES = [name for name, metric in METRICS.items() if metric.takes == "meshes"]
OF_SURFACES = [name for name in OF_MESHES if name not in ("rms_over_diagonal", "max_over_diagonal")]
# The measures that tables and JSON name: others rely on these names.
PROMISED = (
    "rms_over_diagonal", "max_over_diagonal", "mrms_over_diagonal", "hausdorff_over_diagonal", "psnr_db",
    "paper_psnr_db", "msdm2", "normal_deviation_deg", "ber", "correlation", "true_positive_rate",
    "false_positive_rate", "recovered", "precision", "recall", "iou", "recovery_rms_over_diagonal",
    "image_psnr_db", "vertices_per_second", "peak_memory_mb",
)  # fmt: skip


def moved(by: float, vertices: int = 8) -> Mesh:
    """Return the box with the first vertices moved along z."""
    positions = BOX.vertices.copy()
    positions[:vertices, 2] += by
    return BOX.with_vertices(positions)


@lru_cache
def rough(by: float) -> Mesh:
    return MODEL.with_vertices(MODEL.vertices + by * NOISE)


@pytest.fixture(autouse=True)
def few_samples(monkeypatch):
    monkeypatch.setattr(surface_distance, "SAMPLES", 4_000)


def ideal(name):
    metric = METRICS[name]
    return metric.limits[0] if metric.better == "lower" else metric.limits[1]


def test_every_promised_measure_is_there_and_says_what_it_is():
    assert set(PROMISED) <= METRICS.keys()
    for metric in some(METRICS.values()):
        assert metric.limits[0] < metric.limits[1]
        assert metric.meaning
        assert metric.function.__doc__
        assert metric.better in ("lower", "higher")


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


@pytest.mark.parametrize("name", OF_MESHES)
def test_ideal_on_equal_models_and_worse_the_further_they_are(name):
    metric = METRICS[name]
    assert metric(MODEL, MODEL) == ideal(name)
    assert metric(MODEL, Mesh(MODEL.vertices.copy(), MODEL.faces.copy())) == ideal(name)
    values = [metric(MODEL, rough(by)) for by in (0.001, 0.004, 0.016)]
    assert values == sorted(values, reverse=metric.better == "higher")
    assert len(set(values)) == 3
    assert all(metric.limits[0] <= value <= metric.limits[1] for value in values)


@pytest.mark.parametrize("name", OF_MESHES)
@pytest.mark.parametrize("scale", [1e-6, 1e-100, 1e90])
def test_scaling_both_models_changes_nothing(name, scale):
    a, b = (mesh.with_vertices(scale * mesh.vertices) for mesh in (MODEL, rough(0.004)))
    # rounding decides which face of an edge holds a closest point, which MSDM2 feels
    tolerance = 3e-3 if name.startswith("msdm2") else 1e-6
    assert METRICS[name](a, b) == pytest.approx(METRICS[name](MODEL, rough(0.004)), rel=tolerance)


@pytest.mark.parametrize("name", ["mrms_over_diagonal", "hausdorff_over_diagonal", "max_over_diagonal"])
def test_distances_do_not_depend_on_the_axes(name):
    turn = Rotation.random(random_state=3).as_matrix()
    pair = MODEL, rough(0.004)
    turned = [mesh.with_vertices(mesh.vertices @ turn + [3.0, -1.0, 2.0]) for mesh in pair]
    sizes = [np.linalg.norm(np.ptp(mesh.vertices, axis=0)) for mesh in (MODEL, turned[0])]
    # the closer look at the farthest place takes its points along the axes
    tolerance = 1e-3 if name == "hausdorff_over_diagonal" else 1e-6
    assert METRICS[name](*turned) * sizes[1] == pytest.approx(METRICS[name](*pair) * sizes[0], rel=tolerance)
    assert METRICS["normal_deviation_deg"](*turned) == pytest.approx(
        METRICS["normal_deviation_deg"](*pair), rel=1e-6
    )


@pytest.mark.parametrize("name", OF_SURFACES)
def test_the_order_of_vertices_and_faces_does_not_count_between_surfaces(name):
    random = np.random.default_rng(0)
    other = rough(0.004)
    order = random.permutation(len(other.vertices))
    faces = np.argsort(order)[other.faces][random.permutation(len(other.faces))]
    shuffled = Mesh(
        np.vstack([other.vertices[order], other.vertices[:1]]), faces
    )  # another count: no vertex pairs
    plain = Mesh(np.vstack([other.vertices, other.vertices[:1]]), other.faces)
    assert METRICS[name](MODEL, shuffled) == pytest.approx(METRICS[name](MODEL, plain), rel=0.01)


@pytest.mark.parametrize("name", sorted(set(OF_SURFACES) - {"psnr_db", "paper_psnr_db"}))
def test_triangles_that_share_no_vertices_measure_the_same(name):
    soup = [
        Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size).reshape(-1, 3))
        for mesh in (MODEL, rough(0.004))
    ]
    assert METRICS[name](*soup) == pytest.approx(METRICS[name](MODEL, rough(0.004)), rel=0.01)


@pytest.mark.parametrize("name", OF_MESHES)
def test_what_cannot_be_compared_is_refused(name):
    point = Mesh(np.ones((8, 3)), BOX.faces)
    nothing = Mesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    dots = Mesh(BOX.vertices[:7], np.zeros((0, 3), int))
    for a, b in ((BOX, dots), (point, BOX), (nothing, nothing)):
        with pytest.raises(InputError):
            METRICS[name](a, b)


def test_compare_gives_what_the_table_gives():
    other = rough(0.004)
    result = compare(MODEL, other).to_dict()
    assert result == {name: METRICS[name](MODEL, other) for name in result}
    assert set(OF_MESHES) - result.keys() == {"msdm2_symmetric", "recovery_rms_over_diagonal"}


def test_compare_of_other_counts_leaves_out_only_what_pairs_vertices():
    fewer = Mesh(*pebble(20))
    result = compare(MODEL, fewer).to_dict()
    assert {name for name, value in result.items() if value is None} == {
        "rms_over_diagonal", "max_over_diagonal"
    }  # fmt: skip
    assert result["psnr_db"] == pytest.approx(-20 * math.log10(result["symmetric_rms_over_diagonal"]))


def test_compare_of_models_without_a_surface_gives_what_it_can():
    dots = Mesh(BOX.vertices, np.zeros((0, 3), int))
    result = compare(dots, dots.with_vertices(moved(0.07).vertices)).to_dict()
    assert result["rms_over_diagonal"] == pytest.approx(0.01)
    assert result["msdm2"] is result["mrms_over_diagonal"] is result["normal_deviation_deg"] is None


def test_equal_models_are_json_without_infinity():
    equal = compare(BOX, BOX)
    assert equal.psnr_db == math.inf
    assert equal.to_dict()["psnr_db"] is None
    assert equal.to_dict()["rms_over_diagonal"] == equal.to_dict()["msdm2"] == 0.0


def test_inputs_stay_as_they_are():
    a, b = MODEL.vertices.copy(), rough(0.01).vertices.copy()
    mm.compare(Mesh(a, MODEL.faces), Mesh(b, MODEL.faces))
    assert np.array_equal(a, MODEL.vertices)
    assert np.array_equal(b, rough(0.01).vertices)


def test_the_same_models_give_the_same_numbers():
    again = [Mesh(mesh.vertices.copy(), mesh.faces.copy()) for mesh in (MODEL, rough(0.004))]
    assert compare(*again) == compare(MODEL, rough(0.004))
