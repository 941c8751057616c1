"""The surface of a mesh: welded once, shared, and never that of other positions."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry import surface_of as remembered
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.extent import diagonal
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of, surface_of_moved
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.shapes import pebble


def soup(across: int = 16) -> Mesh:
    """Return a mesh each face of which has vertices of its own, and a vertex that no face uses."""
    points, faces = pebble(across)
    corners = points[faces].reshape(-1, 3)
    return Mesh(np.vstack([corners, [[90.0, 0.0, -0.0]]]), np.arange(len(corners)).reshape(-1, 3))


def same(one: Surface, other: Surface) -> bool:
    names = ("points", "faces", "point_of_vertex", "used", "edges", "vertex_of_point", "point_areas")
    return all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in names)


@pytest.fixture
def welds(monkeypatch):
    """Return the list of the meshes that are welded."""
    seen: list[Mesh] = []
    monkeypatch.setattr(remembered, "weld", lambda mesh: seen.append(mesh) or weld(mesh))
    return seen


def test_a_mesh_is_welded_once(welds):
    mesh = soup()
    assert surface_of(mesh) is surface_of(mesh)
    assert same(surface_of(mesh), weld(mesh))
    assert welds == [mesh]


def test_what_is_derived_is_what_its_own_functions_say():
    mesh = soup()
    surface = surface_of(mesh)
    graph = adjacency(unique_edges(surface.faces), len(surface.points))
    assert (surface.graph != graph).nnz == 0
    assert surface.diagonal == diagonal(mesh.vertices, mesh.faces)
    assert surface.frame is surface.frame
    assert surface.frame.scale == canonical_frame(surface.points, surface.faces).scale
    assert surface.used.sum() == len(surface.points) - 1
    assert surface.diagonal < 10.0, "a vertex that no face uses does not count"


@pytest.mark.parametrize("rounded", [False, True])
def test_moved_vertices_keep_the_connectivity_without_another_weld(welds, rounded):
    mesh = soup()
    vertices = 1.5 * mesh.vertices + [0.1, 0.2, 0.3]
    moved = mesh.with_vertices(vertices.astype(np.float32).astype(float) if rounded else vertices)
    surface = surface_of_moved(moved, mesh)
    assert welds == [mesh]
    assert same(surface, weld(moved))
    assert surface_of(moved) is surface
    assert surface.connectivity is surface_of(mesh).connectivity


def test_points_that_rounding_joins_are_welded_anew(welds):
    mesh = soup()
    moved = mesh.with_vertices(np.round(mesh.vertices))
    surface = surface_of_moved(moved, mesh)
    assert welds == [mesh, moved]
    assert len(surface.points) < len(surface_of(mesh).points)
    assert same(surface, weld(moved))


def test_vertices_of_one_point_that_part_are_welded_anew(welds):
    mesh = soup()
    moved = mesh.with_vertices(mesh.vertices + np.arange(len(mesh.vertices))[:, None] * 1e-3)
    assert len(surface_of_moved(moved, mesh).points) == len(mesh.vertices)
    assert welds == [mesh, moved]


def test_other_faces_are_another_surface(welds):
    mesh = soup()
    other = Mesh(mesh.vertices, mesh.faces[:-1])
    assert same(surface_of_moved(other, mesh), weld(other))
    assert welds == [other]


def test_an_array_that_is_changed_under_a_mesh_gets_a_new_surface():
    points, faces = (np.array(each) for each in pebble(16))
    mesh = Mesh(points, faces)
    before = surface_of(mesh)
    points *= 2.0
    assert surface_of(mesh) is not before
    assert surface_of(mesh).diagonal == pytest.approx(2.0 * before.diagonal)
