"""The smoothing brush: by its formula, point by point, and flatter where it went."""

from __future__ import annotations

import numpy as np

from meshmark.attacks.attack import Given
from meshmark.attacks.local_patch import draw_patch
from meshmark.attacks.local_smooth import PASSES, STRONGEST, smooth_part
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.mesh import Mesh
from tests.attacks.surfaces import sheet
from tests.shapes import pebble

MESH = Mesh(*pebble(30))


def smoothed(mesh, share=0.1):
    return smooth_part(mesh, share, np.random.default_rng(3), Given())


def test_each_point_goes_its_way_to_the_mean_of_its_neighbours():
    patch = draw_patch(MESH, 0.1, np.random.default_rng(3))
    around = {point: set() for point in range(len(MESH.vertices))}
    for face in MESH.faces.tolist():
        for point in face:
            around[point] |= set(face) - {point}
    places = MESH.vertices.copy()
    for _ in range(PASSES):
        before = places.copy()
        for point, reach in zip(patch.members.tolist(), patch.reach.tolist(), strict=True):
            mean = before[sorted(around[point])].mean(axis=0)
            places[point] += STRONGEST * (1.0 - reach**2) * (mean - before[point])
    result = smoothed(MESH)
    np.testing.assert_allclose(result.mesh.vertices, places, rtol=0, atol=1e-12)
    assert set(np.flatnonzero(result.altered)) == set(patch.members.tolist())


def test_a_rough_patch_becomes_smoother():
    rough = MESH.with_vertices(
        MESH.vertices + np.random.default_rng(1).normal(0.0, 0.02, MESH.vertices.shape)
    )
    members = draw_patch(rough, 0.1, np.random.default_rng(3)).members
    inner = members[: len(members) // 2]
    graph = adjacency(unique_edges(MESH.faces), len(MESH.vertices))[inner]
    degree = np.asarray(graph.sum(axis=1))[:, None]
    before, after = (
        np.linalg.norm(graph @ mesh.vertices / degree - mesh.vertices[inner], axis=1).mean()
        for mesh in (rough, smoothed(rough).mesh)
    )
    assert after < 0.5 * before


def test_a_flat_sheet_stays_flat_and_inside_it_still():
    points, faces = sheet(12)
    bent = Mesh(points, faces)
    border = (points[:, 1] < 0.5) | (points[:, 1] > points[:, 1].max() - 0.5)
    border |= np.abs(points[:, 0] - 0.5 * points[:, 1] / np.sqrt(0.75) - 6.0) > 5.5
    result = smoothed(bent, 0.05)
    assert not border[draw_patch(bent, 0.05, np.random.default_rng(3)).members].any()
    np.testing.assert_allclose(result.mesh.vertices, points, rtol=0, atol=1e-12)
