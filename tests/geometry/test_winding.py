"""Windings are made consistent where a file has mixed them up; single faces that were turned over stay so."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.winding import consistent_winding
from tests.low_poly import ball, box, joined

POINTS, FACES = ball(2)


def turned_over(faces, share, seed=0):
    rows = np.random.default_rng(seed).random(len(faces)) < share
    return np.where(rows[:, None], faces[:, [0, 2, 1]], faces)


def around(faces):
    """Each face as it turns, from its least point on."""
    first = faces.argmin(axis=1)
    return faces[np.arange(len(faces))[:, None], (first[:, None] + np.arange(3)) % 3]


@pytest.mark.parametrize("share", [0.2, 0.35, 0.45])
def test_most_faces_decide(share):
    mixed = turned_over(FACES, share)
    assert (around(mixed) != around(FACES)).any()
    assert (around(consistent_winding(mixed, len(POINTS))) == around(FACES)).all()


def test_a_consistent_surface_is_the_same_array():
    assert consistent_winding(FACES, len(POINTS)) is FACES


def test_single_faces_that_were_turned_over_stay_so():
    mixed = turned_over(FACES, 0.02)
    assert (mixed != FACES).any()
    assert (consistent_winding(mixed, len(POINTS)) == mixed).all()


def test_components_decide_by_themselves():
    points, faces = joined([ball(1), box((2, 3, 2), (1.0, 1.0, 1.0), (5.0, 0.0, 0.0))])
    own = faces.max(axis=1) < len(ball(1)[0])
    mixed = np.where(own[:, None], turned_over(faces, 0.3), faces[:, [0, 2, 1]])
    found = around(consistent_winding(mixed, len(points)))
    assert (found[own] == around(faces)[own]).all()
    assert (found[~own] == around(mixed)[~own]).all()


def test_a_strip_of_one_side_is_left_alone():
    count = 12
    low, high = np.arange(count), np.arange(count) + count
    after_low = np.concatenate([low[1:], [count]])  # the end is joined to the beginning upside down
    after_high = np.concatenate([high[1:], [0]])
    strip = np.concatenate(
        [np.stack([low, after_low, high], axis=1), np.stack([after_low, after_high, high], axis=1)]
    )
    mixed = turned_over(strip, 0.3)
    assert (consistent_winding(mixed, 2 * count) == mixed).all()


def test_the_order_of_faces_does_not_matter():
    mixed = turned_over(FACES, 0.4)
    order = np.random.default_rng(3).permutation(len(FACES))
    found = consistent_winding(mixed[order], len(POINTS))
    assert (around(found) == around(FACES)[order]).all()
