"""Collusion, the second mark, and the copy attack with a planted mark."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from meshmark.attacks import ATTACKS, Given
from meshmark.errors import InputError
from meshmark.geometry.areas import vertex_normals
from meshmark.mesh import Mesh
from tests.attacks.models import remarked
from tests.shapes import pebble

MODEL = Mesh(*pebble(30))
COPIES = tuple(remarked(MODEL, seed) for seed in range(4))
RNG = np.random.default_rng(1)


@pytest.mark.parametrize("k", [2, 3, 5])
def test_collusion_is_the_mean_of_k_models(k):
    found = ATTACKS["collusion"](MODEL, k, RNG, Given(copies=COPIES)).vertices
    rows = zip(MODEL.vertices.ravel(), *(copy.vertices.ravel() for copy in COPIES[: k - 1]), strict=True)
    expected = [float(sum(map(Fraction, row)) / k) for row in rows]
    np.testing.assert_allclose(found.ravel(), expected, rtol=0, atol=1e-15)


def test_collusion_lessens_what_the_copies_do_not_share():
    away = [
        np.linalg.norm(
            ATTACKS["collusion"](COPIES[0], k, RNG, Given(copies=COPIES[1:])).vertices - MODEL.vertices
        )
        for k in (2, 3, 4)
    ]
    alone = np.linalg.norm(COPIES[0].vertices - MODEL.vertices)
    np.testing.assert_allclose(away, alone / np.sqrt([2, 3, 4]), rtol=0.1)


def test_collusion_refuses_too_few_and_unfitting_copies():
    with pytest.raises(InputError, match="collusion of 5 needs 4 other copies and was given 3"):
        ATTACKS["collusion"](MODEL, 5, RNG, Given(copies=COPIES[:3]))
    turned = Mesh(MODEL.vertices, MODEL.faces[::-1])
    for other in (Mesh(*pebble(24)), turned):
        with pytest.raises(InputError, match="copy 2 has other vertices or faces, expected the same model"):
            ATTACKS["collusion"](MODEL, 3, RNG, Given(copies=(COPIES[0], other)))


def test_the_second_mark_is_what_the_embedder_makes():
    marked = remarked(MODEL, 5)
    result = ATTACKS["second_mark"].apply(
        MODEL, 1, RNG, Given(embed=lambda mesh: marked if mesh is MODEL else mesh)
    )
    assert result.mesh is marked
    np.testing.assert_array_equal(result.origin, np.arange(len(MODEL.vertices)))
    other = ATTACKS["second_mark"].apply(MODEL, 1, RNG, Given(embed=lambda _: Mesh(*pebble(24))))
    assert other.origin is None


def planted(mesh: Mesh) -> np.ndarray:
    """A fine relief, (n,) heights, as a mark might be."""
    return 4e-3 * np.prod(np.cos(8.0 * mesh.vertices), axis=1)


def with_relief(mesh: Mesh) -> Mesh:
    normals = vertex_normals(mesh.vertices, mesh.faces)
    return mesh.with_vertices(mesh.vertices + planted(mesh)[:, None] * normals)


def similar(mesh: Mesh) -> Mesh:
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7])
    return mesh.with_vertices(mesh.vertices @ turn.as_matrix().T * 5.0 + [10.0, 20.0, -3.0])


def test_the_copied_mark_is_the_donor_less_its_gaussian_along_the_normals():
    """Against the matrix exponential of the random walk, dense."""
    donor = with_relief(MODEL)
    size = len(donor.vertices)
    joined = np.zeros((size, size))
    for corner in range(3):
        joined[donor.faces[:, corner], donor.faces[:, corner - 1]] = 1.0
        joined[donor.faces[:, corner - 1], donor.faces[:, corner]] = 1.0
    start, end = np.nonzero(np.triu(joined))
    edge = np.mean(np.sum((donor.vertices[start] - donor.vertices[end]) ** 2, axis=1))
    width = 0.01 * np.linalg.norm(np.ptp(donor.vertices, axis=0))
    walk = joined / joined.sum(axis=1, keepdims=True)
    smooth = expm(2 * width**2 / edge * (walk - np.eye(size))) @ donor.vertices
    heights = np.sum((donor.vertices - smooth) * vertex_normals(donor.vertices, donor.faces), axis=1)
    found = ATTACKS["copy"](donor, 1, RNG, Given(donor=donor)).vertices - donor.vertices
    np.testing.assert_allclose(
        found, heights[:, None] * vertex_normals(donor.vertices, donor.faces), rtol=0, atol=1e-11
    )


@pytest.mark.parametrize("moved", [False, True], ids=["in place", "turned and larger"])
@pytest.mark.parametrize(
    ("across", "least"), [(72, 0.75), (64, 0.65)], ids=["same vertices", "other vertices"]
)
def test_the_copy_attack_carries_a_planted_mark_over(moved, across, least):
    """What it adds with a marked donor, less what it adds with the unmarked one, is the mark."""
    source, target = Mesh(*pebble(72)), Mesh(*pebble(across))
    own = similar(target) if moved else target
    marked, plain = (
        ATTACKS["copy"](own, 1, RNG, Given(donor=donor)).vertices for donor in (with_relief(source), source)
    )
    normals = vertex_normals(own.vertices, own.faces)
    heights = np.sum((marked - plain) * normals, axis=1) / (5.0 if moved else 1.0)
    assert np.corrcoef(heights, planted(target))[0, 1] > least
    assert 0.05 < np.std(heights) / np.std(planted(target)) < 1.0
    np.testing.assert_allclose(np.cross(marked - plain, normals), 0, atol=1e-12)


def test_the_copy_attack_grows_with_its_strength():
    donor = remarked(MODEL, 3)
    one, two = (ATTACKS["copy"](MODEL, share, RNG, Given(donor=donor)).vertices for share in (1, 2))
    np.testing.assert_allclose(two - MODEL.vertices, 2 * (one - MODEL.vertices), atol=1e-13)
