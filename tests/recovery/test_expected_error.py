from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.areas import vertex_normals
from meshmark.recovery.expected_error import expected_errors
from tests.shapes import pebble

SIZES = np.array([20, 300])


@pytest.fixture(scope="module")
def surface():
    """Points, faces, the graph, all points."""
    points, faces = pebble(60)
    return points, faces, adjacency(unique_edges(faces), len(points)), np.arange(len(points))


def test_a_miniature_is_known_by_its_error_on_intact_parts(surface):
    points, faces, graph, every = surface
    assert np.allclose(expected_errors(points, graph, every, (points, faces), SIZES), 0.0, atol=1e-9)
    swollen = points + 0.01 * vertex_normals(points, faces)
    near = expected_errors(points, graph, every, (swollen, faces), SIZES)
    assert 0.0 < near[0] < 0.005  # the boundary tells most of it
    noise = 0.01 * np.random.default_rng(0).normal(size=points.shape)
    rough = expected_errors(points, graph, every, (points + noise, faces), SIZES)
    assert (rough > near).all()


def test_errors_grow_with_the_error_of_the_miniature_and_scale_with_the_scene(surface):
    points, faces, graph, every = surface
    noise = np.random.default_rng(1).normal(size=points.shape)
    small, large = (
        expected_errors(points, graph, every, (points + size * noise, faces), SIZES) for size in (0.002, 0.02)
    )
    assert (large > 3.0 * small).all()
    scaled = expected_errors(8.0 * points, graph, every, (8.0 * (points + 0.002 * noise), faces), SIZES)
    np.testing.assert_allclose(scaled, 8.0 * small, rtol=1e-6)


def test_every_size_has_its_answer_and_like_sizes_the_same_one(surface):
    points, faces, graph, every = surface
    noise = 0.01 * np.random.default_rng(2).normal(size=points.shape)
    found = expected_errors(points, graph, every, (points + noise, faces), np.array([300, 20, 300, 16, 290]))
    assert found[0] == found[2] == found[4]
    assert found[1] == found[3]
    assert (found > 0.0).all()
    assert expected_errors(points, graph, every, (points + noise, faces), np.zeros(0, np.int64)).shape == (0,)


def test_what_lies_in_altered_parts_is_not_looked_at(surface):
    points, faces, graph, every = surface
    far = points.copy()
    far[points[:, 0] > 0.5] += 7.0
    intact = every[points[:, 0] < 0.3]
    found = expected_errors(far, graph, intact, (points, faces), np.array([20]))
    assert found == pytest.approx([0.0], abs=1e-9)
