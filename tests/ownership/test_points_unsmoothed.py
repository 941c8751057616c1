"""Marks at the points of coarse models are read after smoothing, which is taken back exactly."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.geometry.surface_of import surface_of
from meshmark.marking import embed, extract
from meshmark.mesh import Mesh
from meshmark.ownership.search.inverse_smoothing import LARGEST_AREA, SHAPES
from meshmark.ownership.search.points_unsmoothed import readings_of_points_unsmoothed
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.strategies import STRATEGIES
from meshmark.ownership.search.trials import TrialCounter
from tests.counting import some
from tests.keys import ID, KEY, OTHER
from tests.low_poly import ball, box, joined, prism, sheet

MODELS = {"ball": ball(1), "box": box((6, 5, 4), (3.0, 2.0, 1.3)), "prism": prism(16, 6, 3.0)}
WAYS = ("smoothing:5", "smoothing:15", "smoothing_half:3", "taubin:5")


@cache
def marked(name: str) -> Mesh:
    return embed(Mesh(*MODELS[name]), KEY, id=ID, layers="ownership").mesh


def smoothed(name: str, way: str) -> Mesh:
    return parse_chain(f"{way}+similarity:1+float32:1")(marked(name), np.random.default_rng(7))


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("way", WAYS)
def test_a_smoothed_model_is_read(name, way):
    found = extract(smoothed(name, way), KEY)
    assert (found.presence, found.id) == ("present", ID)
    assert found.log10_false_positive <= -6.0


def test_nothing_else_reads_it(monkeypatch):
    kept = tuple(each for each in STRATEGIES if each.name != "smoothing undone at points")
    monkeypatch.setattr("meshmark.ownership.extraction.STRATEGIES", kept)
    assert extract(smoothed("prism", "smoothing:5"), KEY).presence == "absent"


def test_readings_pay_for_all_shapes():
    trials = TrialCounter()
    trials.charge()
    search = Search(surface=surface_of(smoothed("prism", "smoothing:5")), key=KEY, trials=trials)
    for reading in some(readings_of_points_unsmoothed(search)):
        assert reading.hypotheses >= 6 * SHAPES


def test_under_another_key_nothing_locks():
    assert not list(
        readings_of_points_unsmoothed(Search(surface=surface_of(smoothed("prism", "smoothing:5")), key=OTHER))
    )


def test_a_plain_search_leaves_it_out():
    assert extract(smoothed("prism", "smoothing:5"), KEY, search="plain").presence == "absent"


def sheets(count: int, across: int) -> Mesh:
    """Return a pile of wavy sheets, which has far more area than a solid of its size."""
    parts = []
    for number in range(count):
        points, faces = sheet(np.linspace(0.0, 1.0, across), np.linspace(0.0, 1.0, across))
        points[:, 2] = 0.8 * number / count
        points[:, 2] += 0.05 * np.sin(5.0 * points[:, 0] + number) * np.cos(4.0 * points[:, 1])
        parts.append((points, faces))
    return Mesh(*joined(parts))


def test_a_model_of_much_area_is_among_the_shapes_that_it_may_have_had():
    model = sheets(40, 11)
    suspect = surface_of(parse_chain("smoothing:10")(model, np.random.default_rng(0)))
    assert surface_of(model).frame.area > LARGEST_AREA
    shapes = some(Search(surface=suspect, key=KEY).before_smoothing)
    assert min(np.abs(shape.points - surface_of(model).points).max() for shape in shapes) < 1e-9


def test_shapes_beyond_the_range_of_numbers_are_left_out():
    points, faces = ball(2)
    rough = points + 0.05 * np.random.default_rng(0).normal(size=points.shape)
    near = Search(surface=surface_of(Mesh(1e3 * rough, faces)), key=KEY).before_smoothing
    far = Search(surface=surface_of(Mesh(1e99 * rough, faces)), key=KEY).before_smoothing
    assert 0 < len(far) <= len(near)
