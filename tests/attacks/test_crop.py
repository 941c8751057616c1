"""Cropping: the share asked for, a plane between what goes and what stays, faces that follow."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from meshmark.attacks import ATTACKS
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from tests.attacks.models import seam, seamed
from tests.shapes import pebble

MODEL = Mesh(*pebble(30))


def separable(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether a plane parts two sets: a linear programme finds n, c with n.x >= c + 1 and n.x <= c - 1."""
    above = np.column_stack([-one, np.ones(len(one))])
    below = np.column_stack([other, -np.ones(len(other))])
    limits = np.full(len(one) + len(other), -1.0)
    solved = linprog(np.zeros(4), A_ub=np.concatenate([above, below]), b_ub=limits, bounds=(None, None))
    return bool(solved.status == 0)


@pytest.mark.parametrize("share", [0.03, 0.1, 0.333, 0.5, 0.7])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_crop_removes_the_share_beyond_a_plane(share, seed):
    result = ATTACKS["crop"].apply(MODEL, share, np.random.default_rng(seed))
    count = len(MODEL.vertices)
    gone = np.setdiff1d(np.arange(count), result.origin)
    assert abs(len(gone) - share * count) <= 0.5
    np.testing.assert_array_equal(result.mesh.vertices, MODEL.vertices[result.origin])
    assert separable(MODEL.vertices[result.origin], MODEL.vertices[gone])


def test_the_check_of_the_plane_can_fail():
    gone = np.zeros(len(MODEL.vertices), bool)
    gone[::7] = True
    assert not separable(MODEL.vertices[~gone], MODEL.vertices[gone])


@pytest.mark.parametrize("share", [0.1, 0.6])
def test_exactly_the_faces_without_a_removed_vertex_stay(share):
    result = ATTACKS["crop"].apply(MODEL, share, np.random.default_rng(1))
    kept = set(result.origin.tolist())
    expected = [face for face in MODEL.faces.tolist() if kept.issuperset(face)]
    assert result.origin[result.mesh.faces].tolist() == expected


def test_directions_differ_and_have_no_preference():
    means = []
    for seed in range(200):
        result = ATTACKS["crop"].apply(MODEL, 0.05, np.random.default_rng(seed))
        gone = np.setdiff1d(np.arange(len(MODEL.vertices)), result.origin)
        off = MODEL.vertices[gone].mean(axis=0) - MODEL.vertices.mean(axis=0)
        means.append(np.sign(off))
    assert np.abs(np.mean(means, axis=0)).max() < 4.5 / np.sqrt(200)


@pytest.mark.parametrize("share", [0.03, 0.1, 0.5])
def test_vertices_in_one_place_go_or_stay_together(share):
    mesh = seamed()
    result = ATTACKS["crop"].apply(mesh, share, np.random.default_rng(5))
    kept = np.isin(np.arange(len(mesh.vertices)), result.origin)
    first, second = seam(mesh)
    np.testing.assert_array_equal(kept[first], kept[second])
    assert abs((~kept).sum() - share * len(mesh.vertices)) <= 1


def test_every_crop_above_0_removes_something():
    result = ATTACKS["crop"].apply(MODEL, 1e-9, np.random.default_rng(5))
    assert len(result.mesh.vertices) == len(MODEL.vertices) - 1


def test_a_crop_that_leaves_nothing_is_refused():
    for share in (0.999, 1.0):
        with pytest.raises(InputError, match="leaves no surface, expected a smaller share"):
            ATTACKS["crop"](MODEL, share, np.random.default_rng(5))
