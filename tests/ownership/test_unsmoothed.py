"""What a coarse model was smoothed by is taken back exactly, and its mark read."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.geometry.weld import weld
from meshmark.marking import embed, extract
from meshmark.mesh import Mesh
from meshmark.ownership.parameters import LOCK_STEPS, SPACING_TRIES
from meshmark.ownership.search import search
from meshmark.ownership.search import unsmoothed as module
from meshmark.ownership.search.inverse_smoothing import LARGEST_AREA, SHAPES, shapes_before
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import TrialCounter
from tests.counting import some
from tests.keys import ID, KEY
from tests.shapes import pebble


@pytest.fixture(scope="module")
def marked():
    return embed(Mesh(*pebble(28)), KEY, id=ID).mesh


def attacked(mesh, text):
    return parse_chain(text)(mesh, np.random.default_rng(7))


@pytest.mark.parametrize(
    "text",
    ["smoothing:1", "smoothing:10", "smoothing:50", "smoothing_half:2", "smoothing_half:6", "taubin:3"],
)
def test_one_of_the_shapes_is_that_before(text):
    before = Mesh(*pebble(20))
    after = attacked(before, text)
    surface = weld(after)
    off = [np.abs(points - weld(before).points).max() for points in shapes_before(surface)]
    assert min(off) < 1e-3 * np.abs(surface.points - weld(before).points).max()


@pytest.mark.parametrize("text", ["smoothing:50", "smoothing_half:3", "taubin:5"])
def test_a_smoothed_coarse_model_is_read(marked, text):
    found = extract(attacked(marked, f"{text}+float32:1+similarity:1"), KEY)
    assert (found.presence, found.id) == ("present", ID)
    assert found.log10_false_positive <= -6.0


def test_nothing_else_reads_a_smoothed_coarse_model(marked, monkeypatch):
    monkeypatch.setattr(search, "COARSE", 0)
    assert extract(attacked(marked, "taubin:5+float32:1+similarity:1"), KEY).id is None


def test_readings_pay_for_all_that_was_tried(marked):
    surface = weld(attacked(marked, "smoothing:5"))
    trials = TrialCounter()
    for _ in range(4):
        trials.charge()
    # Pilots lock in shapes of a few passes more or less as well.
    readings = list(module.unsmoothed_readings(Search(surface=surface, key=KEY, trials=trials)))
    for number, reading in enumerate(some(readings), start=5):
        charge = number * (number + 1)
        assert reading.hypotheses >= charge * SHAPES * len(LOCK_STEPS) * SPACING_TRIES
    assert min(reading.log10_chance for reading in readings) < -15.0


def test_of_another_model_nothing_is_yielded():
    surface = weld(attacked(Mesh(*pebble(28)), "smoothing:5"))
    assert not list(module.unsmoothed_readings(Search(surface=surface, key=KEY)))


def test_shapes_that_got_rough_are_left_out(marked):
    surface = weld(attacked(marked, "smoothing:5+noise:0.01"))
    areas = [shape.frame.area for shape in Search(surface=surface, key=KEY).before_smoothing]
    assert 0 < len(areas) < SHAPES
    assert max(areas) < max(LARGEST_AREA, 2.0 * surface.frame.area)
    assert len(areas) < len(Search(surface=surface, key=KEY, effort="wide").before_smoothing)


def test_a_fine_mesh_is_left_to_the_restorations(marked, monkeypatch):
    monkeypatch.setattr(search, "COARSE", 100)
    assert not list(module.unsmoothed_readings(Search(surface=weld(marked), key=KEY)))
