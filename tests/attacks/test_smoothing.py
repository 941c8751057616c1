"""Smoothing against a naive loop over neighbours."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import ATTACKS
from meshmark.mesh import Mesh
from tests.attacks.models import odd_strip, seamed
from tests.shapes import pebble

CASES = {
    "smoothing": lambda passes: [0.1] * passes,
    "smoothing_half": lambda passes: [0.5] * passes,
    "taubin": lambda passes: [0.5, -0.53] * passes,
}


def naive(mesh: Mesh, shares: list[float]) -> np.ndarray:
    """Move every place by each share towards the mean of the places joined to it by an edge."""
    places = [tuple(row) for row in mesh.vertices.tolist()]
    around: dict[tuple, set] = {place: set() for place in places}
    for a, b, c in mesh.faces.tolist():
        if len({places[a], places[b], places[c]}) == 3:
            for one, other in ((a, b), (b, c), (c, a)):
                around[places[one]].add(places[other])
                around[places[other]].add(places[one])
    now = {place: np.array(place) for place in around}
    for share in shares:
        now = {
            place: here + share * (sum(now[other] for other in around[place]) / len(around[place]) - here)
            if around[place]
            else here
            for place, here in now.items()
        }
    return np.array([now[place] for place in places])


@pytest.mark.parametrize("mesh", [Mesh(*pebble(18)), seamed(18), odd_strip()], ids=["closed", "seam", "open"])
@pytest.mark.parametrize("passes", [1, 5])
@pytest.mark.parametrize("name", CASES)
def test_smoothing_is_the_loop_of_the_definition(name, passes, mesh):
    smooth = ATTACKS[name](mesh, passes, np.random.default_rng(1))
    np.testing.assert_allclose(smooth.vertices, naive(mesh, CASES[name](passes)), rtol=1e-12, atol=1e-12)


def test_passes_add_up():
    mesh, rng = Mesh(*pebble(18)), np.random.default_rng(1)
    twice = ATTACKS["smoothing"](ATTACKS["smoothing"](mesh, 3, rng), 4, rng)
    np.testing.assert_allclose(twice.vertices, ATTACKS["smoothing"](mesh, 7, rng).vertices, rtol=1e-13)


def test_taubin_keeps_the_size_that_laplacian_smoothing_loses():
    mesh, rng = Mesh(*pebble(24)), np.random.default_rng(1)

    def size(smooth: Mesh) -> float:
        return float(np.linalg.norm(smooth.vertices - smooth.vertices.mean(axis=0), axis=1).mean())

    assert size(ATTACKS["smoothing_half"](mesh, 10, rng)) < 0.95 * size(mesh)
    assert size(ATTACKS["taubin"](mesh, 10, rng)) == pytest.approx(size(mesh), rel=0.01)
