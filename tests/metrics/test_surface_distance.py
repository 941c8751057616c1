"""Surface distances where the answer is known, and against METRO-style reference values."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh

from meshmark.geometry.areas import face_areas
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.mesh import Mesh
from meshmark.metrics import METRICS
from meshmark.metrics.displacement import diagonal
from meshmark.metrics.surface_distance import surface_distances
from meshmark.metrics.surface_samples import sample_edges, sample_faces
from tests.packed import read_packed
from tests.shapes import pebble

SAMPLES = 4_000


def square(size: float = 1.0, height: float = 0.0, parts: int = 5) -> Mesh:
    """A flat square from 0 to `size`, cut into triangles."""
    line = np.linspace(0.0, size, parts + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(line, line))
    here = (np.arange(parts)[:, None] * (parts + 1) + np.arange(parts)).ravel()
    right, up = here + 1, here + parts + 1
    faces = np.concatenate([np.stack([here, right, up], 1), np.stack([right, up + 1, up], 1)])
    return Mesh(np.stack([x, y, np.full(len(x), height)], axis=1), faces)


def ball(radius: float) -> Mesh:
    model = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    return Mesh(np.array(model.vertices), np.array(model.faces))


def test_a_plane_moved_up():
    found = surface_distances(square(), square(height=0.125, parts=7), SAMPLES)
    for value in (found.rms_ab, found.rms_ba, found.area_rms_ab, found.hausdorff_ab, found.hausdorff_ba):
        assert value == pytest.approx(0.125, rel=1e-12)


def test_a_larger_square_is_farther_from_the_smaller_than_back():
    found = surface_distances(square(1.0), square(2.0), SAMPLES)
    assert (found.rms_ab, found.hausdorff_ab) == (pytest.approx(0, abs=1e-12), pytest.approx(0, abs=1e-12))
    assert found.hausdorff_ba == pytest.approx(np.sqrt(2.0))
    # of the larger square: a quarter at 0, two quarters at mean square 1/3, one at 2/3
    assert found.area_rms_ba == pytest.approx(np.sqrt((1 / 3 + 1 / 3 + 2 / 3) / 4), rel=0.01)


def test_concentric_spheres():
    found = surface_distances(ball(1.0), ball(1.1), SAMPLES)
    assert found.rms_ab == pytest.approx(0.1, rel=0.01)
    assert found.hausdorff_ba == pytest.approx(0.1, rel=0.01)
    assert METRICS["hausdorff_over_diagonal"](ball(1.0), ball(1.1)) == pytest.approx(
        0.1 / np.sqrt(12.0), rel=0.01
    )


def test_a_single_spike_is_found_wherever_it_is():
    """The point of a face that is farthest from the other surface lies between the samples."""
    tent = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    far = Mesh(
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.31, 0.23, 0.2]]),
        np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3]]),
    )
    found = surface_distances(tent, far, 200)
    fine = tent.vertices[0] + np.random.default_rng(0).dirichlet([1, 1, 1], 200_000)[:, 1:] @ np.eye(2, 3)
    planted = SurfaceIndex(far.vertices, far.faces).nearest(fine).distances.max()
    assert found.hausdorff_ab == pytest.approx(planted, rel=0.005)
    assert found.hausdorff_ba == pytest.approx(0.2, rel=1e-12)


def test_mrms_is_the_larger_and_the_symmetric_one_the_mean():
    a, b = square(1.0), square(2.0)
    found = surface_distances(a, b)
    assert METRICS["mrms_over_diagonal"](a, b) == max(found.rms_ab, found.rms_ba) / diagonal(a)
    assert METRICS["symmetric_rms_over_diagonal"](a, b) == (found.rms_ab + found.rms_ba) / 2 / diagonal(a)
    assert METRICS["recovery_rms_over_diagonal"](a, b) == METRICS["symmetric_rms_over_diagonal"](a, b)


def test_loose_vertices_are_no_surface():
    a = square()
    loose = Mesh(np.vstack([square(height=0.1).vertices, [[0.5, 0.5, 9.0]]]), a.faces)
    assert surface_distances(a, loose, SAMPLES).hausdorff_ba == pytest.approx(0.1, rel=1e-12)


def test_samples_lie_on_faces_and_edges_and_are_spread_by_size():
    points, faces = pebble(24)
    on_faces = sample_faces(points, faces, 20_000)
    model = trimesh.Trimesh(points, faces, process=False)
    _, distance, _ = trimesh.proximity.closest_point_naive(model, on_faces[::100])
    assert distance.max() < 1e-9
    middles = points[faces].mean(axis=1)
    exact = face_areas(points, faces) @ middles / face_areas(points, faces).sum()
    assert on_faces.mean(axis=0) == pytest.approx(exact, abs=2e-3)
    edges = model.edges_unique
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    exact = lengths @ points[edges].mean(axis=1) / lengths.sum()
    assert sample_edges(points, faces, 20_000).mean(axis=0) == pytest.approx(exact, abs=2e-3)


@pytest.mark.shared
@pytest.mark.parametrize("pair", ["bimba", "cow_smooth30", "cow_simp50"])
def test_within_two_percent_of_a_metro_style_tool(shared_data, pair):
    """Values made with pymeshlab 2025.7, two million samples of vertices, edges and faces (README there)."""
    folder = shared_data / "msdm2"
    values = json.loads((folder / "values.json").read_text())[pair]
    a, b = (read_packed(folder / values[name]) for name in ("original", "degraded"))
    found = surface_distances(a, b)
    for name in ("rms_ab", "rms_ba", "hausdorff_ab", "hausdorff_ba"):
        assert getattr(found, name) == pytest.approx(values[name], rel=0.02), name
    assert found.area_rms_ab == pytest.approx(values["rms_ab_faces_only"], rel=0.02)
    assert found.area_rms_ba == pytest.approx(values["rms_ba_faces_only"], rel=0.02)
