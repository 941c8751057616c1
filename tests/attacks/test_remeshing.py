"""Isotropic remeshing: even edges, the same surface, and a library that cannot take the caller down."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from meshmark.attacks import remeshing as module
from meshmark.attacks.attack import Given
from meshmark.attacks.manifold_pieces import manifold_pieces
from meshmark.attacks.remeshing import remeshing
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from tests.attacks.libraries import need_gpytoolbox
from tests.attacks.surfaces import area, border, directed, euler, is_closed, sheet, unwelded, volume
from tests.counting import some
from tests.shapes import pebble

MESH = Mesh(*pebble(24))


def remeshed(mesh: Mesh, strength: float):
    return remeshing(mesh, strength, np.random.default_rng(0), Given())


@cache
def whole(strength: float):
    need_gpytoolbox()
    return remeshed(MESH, strength)


def lengths(mesh: Mesh):
    ends = np.array([sorted(edge) for edge in {frozenset(edge) for edge in directed(mesh)}])
    return np.linalg.norm(mesh.vertices[ends[:, 0]] - mesh.vertices[ends[:, 1]], axis=1)


@pytest.mark.parametrize("strength", [0.5, 1.0])
def test_edges_get_the_length_asked_for_and_the_surface_stays(strength):
    result = whole(strength)
    after = lengths(result.mesh)
    assert after.mean() == pytest.approx(strength * lengths(MESH).mean(), rel=0.15)
    assert after.std() / after.mean() < 0.5 * lengths(MESH).std() / lengths(MESH).mean()
    assert is_closed(result.mesh)
    assert euler(result.mesh) == 2
    assert volume(result.mesh) == pytest.approx(volume(MESH), rel=0.03)
    dense = (
        np.random.default_rng(1).dirichlet([1, 1, 1], (len(MESH.faces), 40)) @ MESH.vertices[MESH.faces]
    ).reshape(-1, 3)
    assert cKDTree(dense).query(result.mesh.vertices)[0].max() < 0.25 * lengths(MESH).mean()
    assert result.origin is None
    assert result.altered is None
    assert result.mesh.document is None


def test_the_same_again_on_seams_and_in_another_unit():
    need_gpytoolbox()
    for other in (unwelded(MESH), Mesh(MESH.vertices * 2.0**50, MESH.faces)):
        scale = np.ptp(other.vertices) / np.ptp(MESH.vertices)
        result = remeshed(other, 1.0).mesh
        np.testing.assert_array_equal(result.faces, whole(1.0).mesh.faces)
        np.testing.assert_array_equal(result.vertices, whole(1.0).mesh.vertices * scale)


def test_borders_fins_and_touching_parts_stay_together():
    need_gpytoolbox()
    points, faces = sheet(6)
    low = np.min(faces, axis=1)
    fin = [[24, 25, len(points)], [25, 26, len(points)]]  # stands on two inner edges
    mesh = Mesh(np.concatenate([points, [[6.0, 3.0, 2.0]]]), np.concatenate([faces[low != 8], fin]))
    result = remeshed(mesh, 0.5).mesh
    ends = mesh.vertices[sorted({vertex for edge in border(mesh) for vertex in edge})]
    np.testing.assert_allclose(cKDTree(result.vertices).query(ends)[0], 0.0, atol=1e-9)
    assert area(result) == pytest.approx(area(mesh), rel=1e-6)
    count = [len(edge) for edge in (border(mesh), border(result))]
    assert count[0] == count[1]
    assert len(np.unique(result.vertices, axis=0)) == len(result.vertices)


def test_pieces_are_the_same_triangles_joined_as_manifolds_are():
    points, faces = manifold_pieces(MESH.vertices, MESH.faces)
    assert len(points) == len(MESH.vertices)
    np.testing.assert_array_equal(points[faces], MESH.vertices[MESH.faces])
    corner = np.eye(4)[:, :3]
    four = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    beside = np.where(four == 3, 4, four)[:, ::-1]  # mirrored upon the same base
    fifth = np.concatenate([corner, [[1.0, 1.0, 1.0]]])
    for both in (np.concatenate([four, beside[1:]]), np.concatenate([four, beside])):
        points, faces = manifold_pieces(fifth, both)
        np.testing.assert_array_equal(points[faces], fifth[both])
        assert all(count == 1 for count in some(directed(Mesh(points, faces)).values()))
    tip = Mesh(np.concatenate([corner, corner + 1.0]), np.concatenate([four, np.array([0, 5, 6, 7])[four]]))
    assert len(manifold_pieces(tip.vertices, tip.faces)[0]) == 8  # they share a point only: it becomes two
    turned = np.array([[0, 1, 2], [0, 1, 3]])  # both walk 0-1
    assert len(manifold_pieces(corner, turned)[0]) == 6


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("import os; os.abort()", "fails on this model"),
        ("raise ValueError('too twisted')", "too twisted"),
        ("import time; time.sleep(60)", "takes over 1 s"),
    ],
)
def test_a_crash_or_hang_of_the_library_is_an_answer(monkeypatch, tmp_path, program, said):
    child = tmp_path / "child.py"
    child.write_text(program)
    monkeypatch.setattr(module, "find_spec", lambda name: name)
    monkeypatch.setattr(module, "CHILD", child)
    monkeypatch.setattr(module, "SECONDS", 1)
    with pytest.raises(InputError, match=said):
        remeshed(MESH, 1.0)


def test_bad_requests_are_refused(monkeypatch):
    monkeypatch.setattr(module, "find_spec", lambda name: name)
    with pytest.raises(InputError, match=r"expected 0\.2 to 5"):
        remeshed(MESH, 0.1)
    with pytest.raises(InputError, match="the model has no faces"):
        remeshed(Mesh(MESH.vertices, np.zeros((0, 3), int)), 1.0)
    monkeypatch.setattr(module, "MAX_FACES", 100)
    with pytest.raises(InputError, match="expected at most 100"):
        remeshed(MESH, 1.0)
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"meshmark\[remesh\]"):
        remeshed(MESH, 1.0)
