from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import expm

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.areas import vertex_areas, vertex_normals
from meshmark.saliency.nc_dgg import DIAGONAL, saliency
from tests.shapes import sphere_with_a_spike


def test_distance_equals_the_sum_written_out_with_dense_matrices() -> None:
    points, faces, _ = sphere_with_a_spike()
    matrix = adjacency(unique_edges(faces), len(points)).toarray()
    walk = matrix / matrix.sum(axis=1, keepdims=True)
    squares = [float(((points[i] - points[j]) ** 2).sum()) for i, j in np.argwhere(matrix)]
    normals = vertex_normals(points, faces)
    areas = vertex_areas(points, faces) / vertex_areas(points, faces).sum()
    centre = areas @ points
    expected = np.zeros(len(points))
    for j in range(1, 7):
        sigma = j * 0.02 * DIAGONAL * np.sqrt(areas @ ((points - centre) ** 2).sum(axis=1))
        smooth = expm(-2 * sigma**2 / np.mean(squares) * (np.eye(len(points)) - walk)) @ points
        expected += ((smooth - points) * normals).sum(axis=1)
    found = saliency(points, faces, epsilon=0.02)
    np.testing.assert_allclose(found.distance, expected, atol=1e-11)
    size = np.abs(expected)
    np.testing.assert_allclose(found.beta, (size - size.min()) / (size.max() - size.min()), atol=1e-9)


def test_the_spike_stands_out_the_most_and_lies_outside() -> None:
    points, faces, tip = sphere_with_a_spike()
    found = saliency(points, faces)
    assert found.beta.argmax() == tip
    assert found.distance[tip] < 0


def test_turning_moving_scaling_flipping_and_shuffling_change_nothing() -> None:
    points, faces, _ = sphere_with_a_spike()
    rng = np.random.default_rng(5)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    order = rng.permutation(len(points))
    shuffled = np.argsort(order)[faces[rng.permutation(len(faces))]][:, ::-1]
    beta = saliency(points, faces).beta
    moved = saliency((points @ turn * 7.0 + 10.0)[order], shuffled).beta
    np.testing.assert_allclose(moved, beta[order], atol=1e-9)


def test_a_flat_sheet_and_a_mesh_without_edges_have_no_saliency() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    assert not saliency(corners, np.array([[0, 1, 2], [0, 2, 3]])).beta.any()
    assert not saliency(corners, np.zeros((0, 3), np.int64)).beta.any()
