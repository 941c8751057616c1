"""Similarity, stretching and mirroring, by a least-squares fit of the map that was applied."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import ATTACKS
from meshmark.mesh import Mesh
from tests.shapes import pebble

MODEL = Mesh(*pebble(24))
SIZE = float(np.linalg.norm(np.ptp(MODEL.vertices, axis=0)))


def linear_part(after: Mesh, before: Mesh = MODEL) -> tuple[np.ndarray, np.ndarray]:
    """Return A and b of after = A before + b; the fit must be exact."""
    rows = np.column_stack([before.vertices, np.ones(len(before.vertices))])
    solved = np.linalg.lstsq(rows, after.vertices, rcond=None)[0]
    np.testing.assert_allclose(rows @ solved, after.vertices, atol=1e-12 * np.abs(after.vertices).max())
    return solved[:3].T, solved[3]


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def turned_by(matrix: np.ndarray) -> float:
    """Angle of a rotation."""
    return float(np.arccos(np.clip((np.trace(matrix) - 1) / 2, -1, 1)))


@pytest.mark.parametrize("strength", [0.01, 0.3, 1.0])
def test_similarity_turns_scales_and_moves_within_its_strength(strength):
    scales, turns, ways = [], [], []
    for seed in range(60):
        matrix, _ = linear_part(ATTACKS["similarity"](MODEL, strength, np.random.default_rng(seed)))
        scale = np.cbrt(np.linalg.det(matrix))
        np.testing.assert_allclose(matrix @ matrix.T, scale**2 * np.eye(3), atol=1e-9 * scale**2)
        moved = ATTACKS["similarity"](MODEL, strength, np.random.default_rng(seed)).vertices
        scales.append(np.log10(scale))
        turns.append(turned_by(matrix / scale))
        ways.append((moved.mean(axis=0) - MODEL.vertices.mean(axis=0)) / SIZE)
    for values, limit in ((scales, strength), (turns, np.pi * strength), (ways, strength)):
        assert 0.85 * limit < np.abs(values).max() <= limit * (1 + 1e-9)
    assert min(scales) < 0 < max(scales)


def test_full_turns_have_no_preferred_direction():
    images = [
        linear_part(ATTACKS["similarity"](MODEL, 1, np.random.default_rng(seed)))[0] for seed in range(300)
    ]
    unit = np.array([matrix / np.cbrt(np.linalg.det(matrix)) for matrix in images])
    # Each entry of a uniform rotation has mean 0 and variance 1/3.
    assert np.abs(unit.mean(axis=0)).max() < 4.5 * np.sqrt(1 / 3 / 300)
    np.testing.assert_allclose((unit**2).mean(axis=0), 1 / 3, atol=4.5 * np.sqrt(4 / 45 / 300))


@pytest.mark.parametrize("strength", [0.01, 0.05, 0.5])
def test_affine_stretches_by_what_it_says_and_does_not_turn(strength):
    for seed in range(5):
        after = ATTACKS["affine"](MODEL, strength, np.random.default_rng(seed))
        matrix, _ = linear_part(after)
        np.testing.assert_allclose(matrix, np.diag(np.diag(matrix)), atol=1e-12)
        np.testing.assert_allclose(np.sort(np.diag(matrix)), [1 - strength, 1, 1 + strength], rtol=1e-9)
        np.testing.assert_allclose(after.vertices.mean(axis=0), MODEL.vertices.mean(axis=0), atol=1e-12)
        assert volume(after) == pytest.approx(volume(MODEL) * (1 - strength**2))


def test_mirror_is_the_other_hand_of_the_same_outside_and_its_own_inverse():
    after = ATTACKS["mirror"](MODEL, 1, np.random.default_rng(1))
    matrix, _ = linear_part(after)
    np.testing.assert_allclose(matrix, np.diag([-1, 1, 1]), atol=1e-12)
    assert volume(after) == pytest.approx(volume(MODEL))
    np.testing.assert_allclose(np.ptp(after.vertices, axis=0), np.ptp(MODEL.vertices, axis=0))
    np.testing.assert_allclose(after.vertices.min(axis=0), MODEL.vertices.min(axis=0))
    back = ATTACKS["mirror"](after, 1, np.random.default_rng(1))
    np.testing.assert_allclose(back.vertices, MODEL.vertices, atol=1e-14)
    np.testing.assert_array_equal(back.faces, MODEL.faces)
