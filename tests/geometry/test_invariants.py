from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import find_attack
from meshmark.coding.keyed import rotation
from meshmark.errors import InputError
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.invariants import INVARIANTS, LEAST_SHARE, LEAST_SKEW, TINY, shape_invariants
from meshmark.mesh import Mesh
from tests.shapes import pebble

POINTS, FACES = pebble(48)
POINTS.setflags(write=False)
FACES.setflags(write=False)
TRUTH = shape_invariants(POINTS, FACES)


def test_each_number_has_a_name_and_a_known_frame_changes_nothing():
    assert TRUTH.shape == (len(INVARIANTS),)
    np.testing.assert_array_equal(shape_invariants(POINTS, FACES, canonical_frame(POINTS, FACES)), TRUTH)


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_similarities_numbering_and_orientation_change_nothing(mirror):
    rng = np.random.default_rng(0)
    moved = 170.0 * (POINTS * [1.0, 1.0, mirror]) @ rotation(bytes(32)) + [3.0, -900.0, 40.0]
    order = rng.permutation(len(POINTS))
    faces = np.argsort(order)[FACES][rng.permutation(len(FACES))][:, ::-1]
    np.testing.assert_allclose(shape_invariants(moved[order], faces), TRUTH, atol=1e-9)


def test_other_triangles_of_the_same_surface_change_little():
    finer = find_attack("midpoint")(Mesh(vertices=POINTS, faces=FACES), 1, np.random.default_rng(0))
    np.testing.assert_allclose(shape_invariants(finer.vertices, finer.faces), TRUTH, atol=0.01)


def test_a_box_of_twelve_triangles_is_what_its_finer_mesh_is():
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 2.0) for z in (0.0, 3.5)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])
    finer = find_attack("midpoint")(Mesh(vertices=corners, faces=faces), 5, np.random.default_rng(0))
    coarse, fine = shape_invariants(corners, faces), shape_invariants(finer.vertices, finer.faces)
    np.testing.assert_allclose(coarse, fine, atol=0.01)


def test_a_sphere_is_as_calculated():
    points, faces = pebble(160)
    ball = points / np.linalg.norm(points, axis=1)[:, None]
    # z = x / sqrt 2; |z z|^2 = 1/4, its mean is the identity / 6, so the trace is 1/4 - 3/36; five equal parts.
    expected = [
        *np.log([1 / 3 + LEAST_SHARE] * 3),
        *np.log([4 * np.pi, 1.0, 1.0]),
        *np.log([LEAST_SKEW] * 3),
        *np.log([0.2 + LEAST_SHARE] * 5 + [LEAST_SHARE]),
        np.log(1 / 6 + TINY),
    ]
    np.testing.assert_allclose(shape_invariants(ball, faces), expected, atol=0.02)


def test_random_places_of_the_surface_give_the_same():
    rng = np.random.default_rng(5)
    corners = POINTS[FACES]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    face = rng.choice(len(FACES), size=400_000, p=area / area.sum())
    share = rng.dirichlet([1, 1, 1], size=len(face))
    x = np.einsum("nk,nki->ni", share, corners[face])
    x -= x.mean(axis=0)
    size = np.sqrt((x**2).sum(axis=1).mean())
    x /= size
    r = np.linalg.norm(x, axis=1)
    z = x / np.sqrt(1 + r[:, None] ** 2)
    pairs = np.einsum("ni,nj->nij", z, z).reshape(-1, 9)
    values = np.linalg.eigvalsh(np.cov(pairs.T))[::-1][:6]
    third = np.einsum("ni,nj->ij", z, pairs) / len(z)
    expected = [
        *np.log(np.linalg.eigvalsh(x.T @ x / len(x))[::-1] + LEAST_SHARE),
        *np.log([area.sum() / size**2, r.mean(), (r**4).mean()]),
        np.log(np.linalg.norm(z.mean(axis=0)) + LEAST_SKEW),
        np.log(np.linalg.norm((z * (z**2).sum(axis=1)[:, None]).mean(axis=0)) + LEAST_SKEW),
        np.log(np.linalg.norm(third) + LEAST_SKEW),
        *np.log(values / values.sum() + LEAST_SHARE),
        np.log(values.sum() + TINY),
    ]
    np.testing.assert_allclose(TRUTH, expected, atol=0.02)


def test_flat_and_coarse_shapes_have_finite_numbers():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    assert np.isfinite(shape_invariants(square, np.array([[0, 1, 2], [0, 2, 3]]))).all()


def test_no_surface_is_refused():
    with pytest.raises(InputError, match="no surface"):
        shape_invariants(np.array([[0.0, 0, 0], [1, 1, 1], [2, 2, 2]]), np.array([[0, 1, 2]]))
