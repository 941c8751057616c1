"""The voxel round trip: distances against trimesh, sides against a convex hull, closed surfaces near the model."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from meshmark.attacks.attack import Given
from meshmark.attacks.voxel_distance import LONGEST, band_distance, split_triangles
from meshmark.attacks.voxel_winding import solid_nodes
from meshmark.attacks.voxels import HALF_SHEET, voxels
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from tests.attacks.surfaces import area, euler, is_closed, sheet, unwelded, volume
from tests.shapes import pebble

MESH = Mesh(*pebble(40))


def rebuilt(mesh: Mesh, strength: float, seed: int = 0):
    return voxels(mesh, strength, np.random.default_rng(seed), Given())


def distance_to(points, mesh: Mesh):
    surface = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    return trimesh.proximity.closest_point_naive(surface, points)[1]


def nodes_of(shape):
    return np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)


def test_distances_near_the_surface_are_exact():
    rng = np.random.default_rng(5)
    triangles = 5.0 + 6.0 * rng.random((40, 3, 3))
    triangles[-1, 2] = triangles[-1, 1]  # a needle without area
    triangles[-2] = triangles[-2, :1]  # a point
    found = band_distance(split_triangles(triangles), (16, 16, 16), 2.0).ravel()
    nodes = nodes_of((16, 16, 16)).astype(float)
    nearest = np.full(len(nodes), np.inf)
    for triangle in triangles:
        on = trimesh.triangles.closest_point(np.repeat(triangle[None], len(nodes), axis=0), nodes)
        nearest = np.fmin(nearest, np.linalg.norm(nodes - on, axis=1))
    np.testing.assert_allclose(found, np.minimum(nearest, 2.0), atol=2e-3)


def test_pieces_of_a_triangle_tile_it():
    triangles = np.array([[[0.0, 0, 0], [40, 0, 0], [0, 30, 7]], [[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    pieces = split_triangles(triangles)
    sides = np.linalg.norm(pieces - np.roll(pieces, 1, axis=1), axis=2)
    assert sides.max() <= LONGEST

    def vectors(t):
        return np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])

    np.testing.assert_allclose(vectors(pieces).sum(axis=0), vectors(triangles).sum(axis=0))
    np.testing.assert_allclose(
        np.linalg.norm(vectors(pieces), axis=1).sum(), np.linalg.norm(vectors(triangles), axis=1).sum()
    )


def test_sides_are_those_of_a_convex_hull():
    rng = np.random.default_rng(6)
    points = 4.0 + 20.0 * rng.random((60, 3))
    points[:20] = np.rint(points[:20])  # lines of the grid through points and along edges
    hull = ConvexHull(points)
    outward = np.cross(*(points[hull.simplices[:, k]] - points[hull.simplices[:, 0]] for k in (1, 2)))
    turned = (outward * hull.equations[:, :3]).sum(axis=1) < 0
    faces = np.where(turned[:, None], hull.simplices[:, ::-1], hull.simplices).astype(np.int64)
    shape = (30, 30, 30)
    beyond = (nodes_of(shape) @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
    clear = np.abs(beyond) > 1e-9
    np.testing.assert_array_equal(solid_nodes(points, faces, shape).ravel()[clear], (beyond < 0)[clear])


@pytest.mark.parametrize(("strength", "rms"), [(24, 0.2), (48, 0.1)])
def test_a_closed_model_comes_back_much_nearer_than_a_voxel(strength, rms):
    result = rebuilt(MESH, strength)
    voxel = np.ptp(MESH.vertices, axis=0).max() / strength
    some = np.random.default_rng(2).choice(len(result.mesh.vertices), 150)
    apart = distance_to(result.mesh.vertices[some], MESH)
    assert apart.max() < 0.2 * voxel  # every new vertex lies about where the surface cuts the grid
    assert np.sqrt((apart**2).mean()) < 0.03 * voxel
    back = distance_to(MESH.vertices[::12], result.mesh)
    assert np.sqrt((back**2).mean()) < rms * voxel
    assert back.max() < 0.7 * voxel
    assert is_closed(result.mesh)
    assert euler(result.mesh) == 2
    assert volume(result.mesh) == pytest.approx(volume(MESH), rel=3.0 / strength**2 * 4)
    assert result.origin is None
    assert result.altered is None


def test_seed_unit_seams_and_place():
    plain = rebuilt(MESH, 24).mesh
    assert len(rebuilt(MESH, 24, seed=1).mesh.vertices) != len(plain.vertices)
    for other in (MESH, unwelded(MESH), Mesh(MESH.vertices * 2.0**-40, MESH.faces)):
        scale = np.ptp(other.vertices) / np.ptp(MESH.vertices)
        result = rebuilt(other, 24).mesh
        np.testing.assert_array_equal(result.faces, plain.faces)
        np.testing.assert_array_equal(result.vertices, plain.vertices * scale)
    loose = Mesh(np.concatenate([MESH.vertices, [[99.0, 0.0, 0.0]]]), MESH.faces)
    np.testing.assert_array_equal(rebuilt(loose, 24).mesh.vertices, plain.vertices)


def test_a_model_inside_out_stays_so():
    inside_out = rebuilt(Mesh(MESH.vertices, MESH.faces[:, ::-1]), 24).mesh
    assert is_closed(inside_out)
    assert volume(inside_out) == pytest.approx(-volume(rebuilt(MESH, 24).mesh), rel=1e-3)


def test_a_cavity_stays_and_parts_that_overlap_become_one():
    count = len(MESH.vertices)
    hollow = Mesh(
        np.concatenate([MESH.vertices, 0.5 * MESH.vertices]),
        np.concatenate([MESH.faces, MESH.faces[:, ::-1] + count]),
    )
    result = rebuilt(hollow, 48).mesh
    assert volume(result) == pytest.approx(volume(MESH) * 7 / 8, rel=0.01)
    assert euler(result) == 4
    twice = Mesh(
        np.concatenate([MESH.vertices, MESH.vertices + np.array([0.8, 0.0, 0.0])]),
        np.concatenate([MESH.faces, MESH.faces + count]),
    )
    assert euler(rebuilt(twice, 48).mesh) == 2


def test_a_hole_is_closed_straight_across():
    top = MESH.vertices[:, 2] > 0.9 * MESH.vertices[:, 2].max()
    cut = Mesh(MESH.vertices, MESH.faces[~top[MESH.faces].any(axis=1)])
    assert not is_closed(cut)
    result = rebuilt(cut, 48).mesh
    assert is_closed(result)
    assert 0.95 * volume(MESH) < volume(result) < volume(MESH)


def test_an_open_sheet_gets_a_thickness():
    flat = Mesh(*sheet(8))
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    for mesh in (flat, Mesh(flat.vertices @ turn, flat.faces)):
        result = rebuilt(mesh, 48).mesh
        voxel = np.ptp(mesh.vertices, axis=0).max() / 48
        assert is_closed(result)
        assert volume(result) == pytest.approx(2 * HALF_SHEET * voxel * area(mesh), rel=0.15)
        some = result.vertices[::20]
        np.testing.assert_allclose(distance_to(some, mesh), HALF_SHEET * voxel, atol=0.15 * voxel)


def test_bad_requests_are_refused(monkeypatch):
    for strength in (3, 20.5, 513):
        with pytest.raises(InputError, match="expected 4 to 512 whole voxels"):
            rebuilt(MESH, strength)
    with pytest.raises(InputError, match="the model has no faces"):
        rebuilt(Mesh(MESH.vertices, np.zeros((0, 3), int)), 16)
    monkeypatch.setitem(sys.modules, "skimage.measure", None)
    with pytest.raises(InputError, match=r"needs skimage.*meshmark\[attacks\]"):
        rebuilt(MESH, 16)
