"""Simplification: the share asked for, evenly over the model, on any unit, and which vertex each one was."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks.attack import Given
from meshmark.attacks.simplification import simplification
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from tests.attacks.surfaces import euler, is_closed, unwelded, volume
from tests.shapes import pebble

MESH = Mesh(*pebble(40))


def simplified(mesh: Mesh, strength: float):
    return simplification(mesh, strength, np.random.default_rng(0), Given())


@pytest.mark.parametrize("strength", [0.001, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95])
def test_removes_the_share_asked_for_and_keeps_the_shape(strength):
    result = simplified(MESH, strength)
    target = (1.0 - strength) * len(MESH.faces)
    assert target - 2 <= len(result.mesh.faces) <= target + 1
    assert is_closed(result.mesh)
    assert euler(result.mesh) == 2
    assert volume(result.mesh) == pytest.approx(volume(MESH), rel=0.002 if strength < 0.6 else 0.07)
    assert result.mesh.document is None
    assert result.altered is None


@pytest.mark.parametrize("strength", [0.1, 0.5, 0.9])
def test_origin_names_the_vertex_that_was_left(strength):
    result = simplified(MESH, strength)
    assert len(np.unique(result.origin)) == len(result.origin) == len(result.mesh.vertices)
    apart = np.linalg.norm(result.mesh.vertices[:, None] - MESH.vertices, axis=2)
    still = apart.min(axis=1) < 1e-9  # vertices that no collapse moved can be found by their place
    assert still.sum() >= (1.0 - strength - 0.3) * len(still)
    np.testing.assert_array_equal(result.origin[still], apart.argmin(axis=1)[still])
    own = np.linalg.norm(result.mesh.vertices - MESH.vertices[result.origin], axis=1)
    edge = np.sqrt(3.0 / (1.0 - strength)) * 0.15  # no vertex strays further than a few new edges
    assert own.max() < 2.0 * edge


def test_a_collapse_of_one_edge_joins_its_two_ends():
    result = simplified(MESH, 2.0 / len(MESH.faces))
    assert len(result.mesh.faces) == len(MESH.faces) - 2
    assert len(np.setdiff1d(np.arange(len(MESH.vertices)), result.origin)) == 1
    own = np.linalg.norm(result.mesh.vertices - MESH.vertices[result.origin], axis=1)
    assert (own > 1e-9).sum() == 1


def test_the_cheapest_edges_go_wherever_they_are_in_the_file():
    points, faces = pebble(40)
    half = points[faces].mean(axis=1)[:, 0] > 0
    halves = Mesh(points, np.concatenate([faces[half], faces[~half]]))
    gone = np.setdiff1d(np.arange(len(points)), simplified(halves, 0.2).origin)
    again = np.setdiff1d(np.arange(len(points)), simplified(Mesh(points, faces[::-1]), 0.2).origin)
    ahead = (points[gone, 0] > 0).mean()
    assert 0.25 < ahead < 0.75
    assert ahead == pytest.approx((points[again, 0] > 0).mean(), abs=0.05)


@pytest.mark.parametrize("scale", [2.0**-40, 2.0**-10, 2.0**17, 2.0**60])
def test_any_unit_gives_the_same_faces(scale):
    here, there = simplified(MESH, 0.5), simplified(Mesh(MESH.vertices * scale, MESH.faces), 0.5)
    np.testing.assert_array_equal(there.mesh.faces, here.mesh.faces)
    np.testing.assert_array_equal(there.mesh.vertices, here.mesh.vertices * scale)


def test_seams_stay_closed_and_loose_vertices_go():
    plain, split = simplified(MESH, 0.5), simplified(unwelded(MESH), 0.5)
    assert is_closed(split.mesh)
    assert len(split.mesh.faces) == len(plain.mesh.faces)
    loose = Mesh(np.concatenate([[[9.0, 9.0, 9.0]], MESH.vertices]), MESH.faces + 1)
    result = simplified(loose, 0.5)
    np.testing.assert_array_equal(result.origin, plain.origin + 1)
    assert np.abs(result.mesh.vertices).max() < 3.0


def test_a_share_of_one_is_refused():
    with pytest.raises(InputError, match="expected a share of faces below 1"):
        simplified(MESH, 1.0)
