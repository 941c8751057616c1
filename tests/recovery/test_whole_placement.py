"""Where a whole lies in a damaged copy, to the precision of the copy's coordinates."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.extent import diagonal
from meshmark.geometry.similarity import Similarity, rotation_of
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.recovery.whole_again import whole_again
from meshmark.recovery.whole_placement import place_whole
from tests.shapes import pebble

POSE = Similarity(scale=2.5, rotation=rotation_of(np.array([0.3, 1.0, 0.4])), shift=np.array([3.0, 4.0, 5.0]))
NEAR = {"same": 1e-6, "within": 1e-4}


def a_little_off() -> list[Similarity]:
    turn = rotation_of(np.array([0.0, 0.004, 0.0]))
    return [Similarity.identity(), Similarity(scale=1.001, rotation=turn, shift=np.zeros(3)).after(POSE)]


def damaged(seed: int, *, cut: bool):
    """A turned pebble with a bump, in another order, perhaps with a piece gone; and which points were moved."""
    points, faces = pebble(40)
    order = np.random.default_rng(seed).permutation(len(points))
    places, corners = points[order], np.argsort(order)[faces]
    bump = places[:, 0] > np.quantile(places[:, 0], 0.93)
    places = np.where(bump[:, None], 1.04 * places, places)
    if cut:
        kept = places[:, 1] > np.quantile(places[:, 1], 0.2)
        corners = (np.cumsum(kept) - 1)[corners[kept[corners].all(axis=1)]]
        places, bump, order = places[kept], bump[kept], order[kept]
    whole = weld(Mesh(points, faces))
    return whole, weld(Mesh(POSE(places).astype(np.float32).astype(float), corners)), bump, order


@pytest.mark.parametrize("cut", [False, True])
def test_points_are_matched_and_what_was_moved_is_found(cut):
    whole, copy, bump, order = damaged(1, cut=cut)
    placed = place_whole(copy, whole, np.ones(len(bump), bool), a_little_off, **NEAR)
    assert np.array_equal(placed.match, order)
    assert np.array_equal(placed.moved, bump)
    assert placed.share == pytest.approx(1.0 - bump.mean())
    assert np.abs(placed.points - POSE(whole.points)).max() < 1e-7 * diagonal(copy.points, copy.faces)


def test_the_copy_comes_back_whole_and_what_stayed_is_the_same_to_the_bit():
    whole, copy, bump, order = damaged(2, cut=True)
    placed = place_whole(copy, whole, ~bump, a_little_off, **NEAR)
    made = whole_again(copy, bump, placed.match, placed.points, whole.faces)
    stayed = ~bump
    assert np.array_equal(made.points[: len(copy.points)][stayed], copy.points[stayed])
    assert np.array_equal(made.moved[: len(bump)], bump)
    of_whole = np.concatenate([order, np.setdiff1d(np.arange(len(whole.points)), order)])
    assert np.array_equal(of_whole[made.faces], whole.faces)
    assert np.abs(made.points - placed.points[of_whole]).max() < 1e-6 * diagonal(copy.points, copy.faces)
    assert made.added.sum() == len(whole.faces) - len(copy.faces)


def test_a_copy_with_the_same_faces_needs_no_guess_and_stays_in_its_place():
    points, faces = pebble(24)
    moved = np.arange(len(points)) % 5 == 0
    copy = weld(Mesh(points + 0.1 * moved[:, None], faces))
    placed = place_whole(copy, weld(Mesh(points, faces)), np.ones(len(points), bool), list, **NEAR)
    assert np.array_equal(placed.points, points)
    assert np.array_equal(placed.moved, moved)


def test_another_model_does_not_fit():
    whole, copy, bump, _ = damaged(3, cut=True)
    other = weld(Mesh(whole.points * [1.0, 1.3, 0.8], whole.faces))
    assert place_whole(copy, other, ~bump, a_little_off, **NEAR) is None
    assert place_whole(copy, whole, ~bump, list, **NEAR) is None
    same = weld(Mesh(whole.points * [1.0, 1.3, 0.8] + 0.1, whole.faces))
    assert place_whole(whole, same, np.ones(len(whole.points), bool), list, **NEAR) is None
