"""Noise against its definition: amplitude over the mean vertex-centroid distance, distribution, independence."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from meshmark.attacks import ATTACKS
from meshmark.mesh import Mesh
from tests.attacks.models import seam, seamed
from tests.shapes import pebble

MODEL = Mesh(*pebble(48))


def mean_radius(mesh: Mesh) -> float:
    """r by the definition, in plain Python."""
    rows = mesh.vertices.tolist()
    centre = [math.fsum(row[axis] for row in rows) / len(rows) for axis in range(3)]
    return math.fsum(math.dist(row, centre) for row in rows) / len(rows)


def moves(name: str, strength: float, mesh: Mesh = MODEL, seed: int = 4) -> np.ndarray:
    attacked = ATTACKS[name](mesh, strength, np.random.default_rng(seed))
    return (attacked.vertices - mesh.vertices) / mean_radius(mesh)


@pytest.mark.parametrize("strength", [0.0005, 0.005, 0.05])
def test_uniform_noise_fills_its_range_and_never_leaves_it(strength):
    found = moves("noise", strength)
    assert np.abs(found).max() <= strength * (1 + 1e-9)
    assert np.abs(found).max() > 0.99 * strength
    assert stats.kstest(found.ravel(), stats.uniform(-strength, 2 * strength).cdf).pvalue > 0.001


@pytest.mark.parametrize("strength", [0.01, 0.05])
def test_gaussian_noise_is_normal_with_the_deviation_asked_for(strength):
    found = moves("gaussian", strength)
    assert stats.kstest(found.ravel(), stats.norm(0, strength).cdf).pvalue > 0.001


@pytest.mark.parametrize("name", ["noise", "gaussian"])
def test_coordinates_and_vertices_are_independent(name):
    found = moves(name, 0.01)
    between_axes = np.corrcoef(found.T) - np.eye(3)
    between_vertices = [np.corrcoef(found[1:, axis], found[:-1, axis])[0, 1] for axis in range(3)]
    assert np.abs([*between_axes.ravel(), *between_vertices]).max() < 4.5 / math.sqrt(len(found))


@pytest.mark.parametrize("name", ["noise", "gaussian"])
def test_a_model_elsewhere_and_of_another_size_gets_the_same_noise(name):
    far = MODEL.with_vertices(1024.0 * MODEL.vertices + 4096.0)
    np.testing.assert_allclose(moves(name, 0.01, far), moves(name, 0.01), atol=1e-9)


@pytest.mark.parametrize("name", ["noise", "gaussian"])
def test_both_sides_of_a_seam_move_alike_and_within_the_range(name):
    mesh = seamed()
    first, second = seam(mesh)
    found = moves(name, 0.01, mesh)
    np.testing.assert_array_equal(found[first], found[second])
    assert (found != 0).all()
