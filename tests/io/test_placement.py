"""Stored rows and their showings: there and back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from meshmark.io.placement import Affine, Placement, place, pull_back


def random_affine(rng: np.random.Generator) -> Affine:
    turn = Rotation.random(rng=rng).as_matrix()
    return Affine(turn * rng.uniform(0.2, 5, 3), rng.normal(size=3) * 10)


@given(st.integers(0, 10**6))
def test_what_is_moved_in_storage_is_pulled_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    stored = rng.normal(size=(9, 3))
    groups = [np.arange(5), np.arange(3, 9), np.array([8, 8, 0])]
    placements = [Placement(slots, random_affine(rng)) for slots in groups]
    goal = stored.copy()
    goal[[0, 4, 8]] += rng.normal(size=(3, 3))
    target, moved = pull_back(stored, placements, place(stored, placements), place(goal, placements))
    assert np.allclose(target, goal)
    assert np.flatnonzero(moved).tolist() == [0, 4, 8]
    still = np.setdiff1d(np.arange(9), [0, 4, 8])
    assert np.array_equal(target[still], stored[still])


@given(st.integers(0, 10**6))
def test_maps_compose_as_matrices_do(seed: int) -> None:
    rng = np.random.default_rng(seed)
    outer, inner, points = random_affine(rng), random_affine(rng), rng.normal(size=(4, 3))
    assert np.allclose(outer.after(inner)(points), outer(inner(points)))
    assert np.allclose(inner.undone(points) @ inner.linear.T, points)
    assert np.array_equal(inner(points)[2:], inner(points[2:]))


def test_identity_returns_the_very_same_numbers() -> None:
    points = np.array([[-0.0, 1e-300, 0.1]])
    assert Affine.identity()(points) is points


@pytest.mark.parametrize(
    ("stretch", "usable"), [((1, 1, 0), False), ((1, 1, 1e-12), False), ((1, -2, 1e-3), True)]
)
def test_flattening_maps_are_known(stretch: tuple[float, ...], usable: bool) -> None:
    assert Affine(np.diag(stretch), np.zeros(3)).is_usable is usable
