from __future__ import annotations

import numpy as np

from meshmark.geometry.open_edges import sample_open_edges
from tests.shapes import pebble


def test_a_closed_surface_has_none():
    points, faces = pebble(16)
    edges = sample_open_edges(points, faces, 0.1)
    assert edges.positions.shape == (0, 3)
    assert edges.motion.shape == (0, len(points))


def test_a_square_of_two_triangles_is_walked_once_round_its_border():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    edges = sample_open_edges(points, np.array([[0, 1, 2], [0, 2, 3]]), 0.3)
    assert len(edges.positions) == 16  # four edges of four pieces
    np.testing.assert_allclose(edges.steps.sum(axis=0), 0.0, atol=1e-15)
    # Green: half the line integral of x x dl is the area, counter-clockwise
    area = 0.5 * np.cross(edges.positions, edges.steps)[:, 2].sum()
    np.testing.assert_allclose(area, 1.0)
    np.testing.assert_allclose(edges.motion @ points, edges.positions)


def test_an_edge_between_faces_that_disagree_counts_twice():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    edges = sample_open_edges(points, np.array([[0, 1, 2], [0, 3, 2]]), 10.0)
    lengths = np.sort(np.linalg.norm(edges.steps, axis=1))
    np.testing.assert_allclose(lengths, [1, 1, 1, 1, 2 * np.sqrt(2)])
