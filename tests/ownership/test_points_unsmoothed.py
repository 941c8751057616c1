"""Marks at the points of coarse models are read after smoothing, which is taken back exactly."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.geometry.surface_of import surface_of
from meshmark.marking import embed, extract
from meshmark.mesh import Mesh
from meshmark.ownership.search.inverse_smoothing import SHAPES
from meshmark.ownership.search.points_unsmoothed import readings_of_points_unsmoothed
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.strategies import STRATEGIES
from meshmark.ownership.search.trials import TrialCounter
from tests.counting import some
from tests.keys import ID, KEY, OTHER
from tests.low_poly import ball, box, prism

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
