from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.registration.surfels import Surfels
from meshmark.geometry.registration.windows import look

STEP = 0.02
GRID = np.stack(np.meshgrid(*[np.arange(-1, 1, STEP) + STEP / 2] * 2), axis=-1).reshape(-1, 2)
UP = np.array([[0.0, 0.0, 1.0]])


def sheet(height: np.ndarray, normals: np.ndarray | None = None) -> Surfels:
    places = np.column_stack([GRID, height])
    facing = np.tile(UP, (len(GRID), 1)) if normals is None else normals
    return Surfels(places=places, normals=facing, areas=np.full(len(GRID), STEP**2))


def test_a_plane_is_seen_at_its_height():
    seen = look(sheet(np.full(len(GRID), 0.03)), np.zeros((1, 3)), UP, 0.1)
    assert seen.heights[0] == pytest.approx(0.03)
    # The Gaussian of width s, cut at 2.5 s, holds 1 - exp(-2.5^2 / 2) of 2 pi s^2.
    cut = (2.5**2 - 0.3**2) / 2.0
    assert seen.masses[0] == pytest.approx(np.exp(-0.5 * 0.3**2) - np.exp(-0.5 * 0.3**2 - cut), rel=0.02)
    assert seen.flatness[0] == pytest.approx(1.0)
    np.testing.assert_allclose(seen.middles[0], [0.0, 0.0, 0.03], atol=1e-12)
    np.testing.assert_allclose(seen.facing, UP)


def test_what_faces_away_is_not_seen():
    both = sheet(np.where(GRID[:, 0] > 0, 0.05, 0.0), np.where(GRID[:, :1] > 0, -UP, UP))
    assert look(both, np.zeros((1, 3)), UP, 0.1).heights[0] == 0.0


def test_nothing_in_the_window():
    seen = look(sheet(np.zeros(len(GRID))), np.array([[0.0, 0.0, 9.0]]), UP, 0.1)
    assert (seen.masses[0], seen.heights[0], seen.flatness[0]) == (0.0, 0.0, 0.0)
    np.testing.assert_array_equal(seen.facing, UP)


def test_a_window_is_the_weighted_mean_written_out():
    rng = np.random.default_rng(0)
    normals = np.tile(UP, (len(GRID), 1)) + 0.4 * rng.normal(size=(len(GRID), 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    pieces = sheet(0.05 * rng.normal(size=len(GRID)), normals)
    place, width = np.array([0.1, -0.2, 0.01]), 0.12
    step = pieces.places - place
    near = np.linalg.norm(step, axis=1) < 2.5 * width
    weight = np.exp(-np.square(step[near]).sum(axis=1) / (2 * width**2)) * STEP**2
    weight *= np.maximum(normals[near, 2], 0.0)
    seen = look(pieces, place[None], UP, width)
    assert seen.heights[0] == pytest.approx((weight * step[near, 2]).sum() / weight.sum(), abs=1e-12)
    assert seen.masses[0] == pytest.approx(weight.sum() / (2 * np.pi * width**2))
