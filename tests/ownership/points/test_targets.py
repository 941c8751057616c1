"""Where points go so that their coordinates say their bits."""

from __future__ import annotations

import numpy as np

from meshmark.coding.codec import Codec
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.points import targets
from meshmark.ownership.points.coordinates import held
from meshmark.ownership.points.parameters import GUARD, SIDE
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.targets import Quantiser, Word, nearest_places
from tests.keys import ID, KEY

LATTICE = PointLattice.keyed(KEY, Label(bytes(16)))
BITS = Codec(KEY).encode(ID)
STEP = 0.003


def points_and_ways(count: int = 400, seed: int = 1):
    random = np.random.default_rng(seed)
    root = random.normal(size=(count, 3, 3))
    carried = random.random((count, 3)) < 0.6
    follow, _ = held(root @ root.transpose(0, 2, 1) + 0.3 * np.eye(3), carried)
    return random.normal(size=(count, 3)), follow, carried


def off(points: np.ndarray, step: float = STEP) -> np.ndarray:
    """Return how far coordinates are from saying their bits, in steps."""
    keys = LATTICE.keys(LATTICE.cubes(points))
    turns = points / step - keys.dither - BITS[keys.code_index] / 2.0
    return np.abs(turns - np.round(turns))


def test_set_points_say_the_bits_of_the_cube_that_they_end_in():
    points, follow, carried = points_and_ways()
    motion, done = nearest_places(points, follow, Quantiser(lattice=LATTICE, message=Word(BITS), step=STEP))
    assert done.mean() > 0.97
    assert off(points + motion)[carried & done[:, None]].max() < 1e-9
    assert off(points)[carried].mean() > 0.2


def test_they_end_clear_of_the_sides():
    points, follow, _ = points_and_ways()
    motion, done = nearest_places(points, follow, Quantiser(lattice=LATTICE, message=Word(BITS), step=STEP))
    places = LATTICE.places(points + motion)[done]
    inside = np.abs(places - np.floor(places) - 0.5)
    assert inside.max() < 0.5 - GUARD * STEP / SIDE
    free = LATTICE.places(points)
    assert np.abs(free - np.floor(free) - 0.5).max() > 0.5 - GUARD * STEP / SIDE


def test_most_go_to_the_nearest_of_the_places():
    points, _, _ = points_and_ways()
    follow = np.broadcast_to(np.eye(3), (len(points), 3, 3))
    motion, done = nearest_places(points, follow, Quantiser(lattice=LATTICE, message=Word(BITS), step=STEP))
    assert done.all()
    near = np.abs(motion).max(axis=1) <= 0.5 * STEP * (1.0 + 1e-9)
    assert near.mean() > 0.8
    assert np.abs(motion).max() < 2.5 * STEP


def test_a_point_that_carries_nothing_stays():
    points, follow, _ = points_and_ways()
    motion, _ = nearest_places(
        points, 0.0 * follow, Quantiser(lattice=LATTICE, message=Word(BITS), step=STEP)
    )
    assert not motion.any()


def test_points_that_were_moved_apart_go_to_the_same_places_of_their_aims():
    aims, _, _ = points_and_ways()
    random = np.random.default_rng(2)
    follow = np.broadcast_to(np.eye(3), (len(aims), 3, 3))
    quantiser = Quantiser(lattice=LATTICE, message=Word(BITS), step=STEP)
    ends = []
    for _ in range(2):
        points = aims + STEP * random.normal(size=aims.shape)
        motion, done = nearest_places(points, follow, quantiser, aims)
        ends.append((points + motion)[done])
    assert len(ends[0]) > 0.97 * len(aims)
    assert np.abs(ends[0] - ends[1]).max() < 1e-12


def test_places_that_differ_only_in_coordinates_that_are_not_set_need_not_be_tried(monkeypatch):
    """The same motions, bit by bit, as where all steps beside the nearest place are tried."""
    points, follow, carried = points_and_ways(600)
    assert set(carried.sum(axis=1)) == {0, 1, 2, 3}
    quantiser = Quantiser(lattice=LATTICE, message=Word(BITS), step=STEP)
    found = []
    for beside, rows in ((targets._BESIDE, 50), ([targets.BESIDE] * 8, 1000)):
        monkeypatch.setattr(targets, "_BESIDE", beside)
        monkeypatch.setattr(targets, "ROWS", rows)
        found.append(nearest_places(points, follow, quantiser))
    (motion, done), (other, other_done) = found
    np.testing.assert_array_equal(motion, other)
    np.testing.assert_array_equal(done, other_done)
    assert motion.any(axis=1).mean() > 0.8
