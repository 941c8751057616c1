"""Closest points against brute force, a second formula, and places where the answer is known."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from meshmark.errors import InputError
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.point_triangle import Triangles
from tests.counting import some
from tests.shapes import pebble


def brute_force(points, faces, queries):
    """Distance to the nearest of all triangles, by bisection-free convex quadratic: corners, sides, plane."""
    out = []
    for q in queries:
        best = np.inf
        for a, b, c in points[faces]:
            best = min(best, *(segment(q, *side) for side in ((a, b), (b, c), (c, a))))
            normal = np.cross(b - a, c - a)
            if (square := normal @ normal) > 0.0:
                foot = q - (q - a) @ normal / square * normal
                turns = [np.cross(y - x, foot - x) @ normal for x, y in ((a, b), (b, c), (c, a))]
                if min(turns) >= 0.0:
                    best = min(best, np.linalg.norm(q - foot))
        out.append(best)
    return np.array(out)


def segment(q, a, b):
    d = b - a
    t = np.clip((q - a) @ d / (d @ d), 0.0, 1.0) if d.any() else 0.0
    return np.linalg.norm(q - a - t * d)


def soup(random, kind, count=40):
    """Triangles with corners in the unit cube: of like size, needles, without area, or of all sizes."""
    corners = random.random((count, 1, 3)) + 0.2 * random.normal(size=(count, 3, 3))
    if kind == "needles":
        corners = random.random((count, 1, 3)) + np.outer(
            random.normal(size=count * 3), [1, 1, 1e-4]
        ).reshape(count, 3, 3)
        corners += 1e-4 * random.normal(size=corners.shape)
    elif kind == "flat":
        corners[::2, 2] = corners[::2, 0] + random.random((len(corners[::2]), 1)) * (
            corners[::2, 1] - corners[::2, 0]
        )
        corners[::5] = corners[::5, :1]
    elif kind == "uneven":
        corners = corners[:, :1] + (corners - corners[:, :1]) * 10.0 ** random.uniform(-4, 1, (count, 1, 1))
    elif kind == "grid":
        corners = np.round(corners * 3) / 3
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


@pytest.mark.parametrize("kind", ["like", "needles", "flat", "uneven", "grid"])
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=4, deadline=None)
def test_as_brute_force(kind, seed):
    random = np.random.default_rng(seed)
    points, faces = soup(random, kind)
    queries = np.concatenate([random.random((15, 3)), 5 * random.normal(size=(5, 3)), points[::29]])
    found = SurfaceIndex(points, faces).nearest(queries)
    assert found.distances == pytest.approx(brute_force(points, faces, queries), abs=2e-13)
    # the point, the weights and the face say the same
    assert found.weights.min() >= 0.0
    assert found.weights.sum(axis=1) == pytest.approx(np.ones(len(queries)), abs=1e-14)
    points_there = np.einsum("nc,nck->nk", found.weights, points[faces[found.faces]])
    assert points_there == pytest.approx(found.points, abs=1e-13)
    assert np.linalg.norm(queries - found.points, axis=1) == pytest.approx(found.distances, abs=1e-13)


def test_every_face_of_many_matters():
    points, faces = pebble(48)
    triangles = Triangles.of(points, faces)
    random = np.random.default_rng(3)
    queries = np.concatenate(
        [random.normal(size=(40, 3)), points[::60] + 1e-3 * random.normal(size=points[::60].shape)]
    )
    every = np.arange(len(faces))
    best = [triangles.closest(np.tile(q, (len(faces), 1)), every)[0].min() for q in queries]
    assert SurfaceIndex(points, faces).nearest(queries).distances == pytest.approx(np.array(best), abs=1e-14)


def test_as_trimesh_finds_them():
    points, faces = pebble(24)
    queries = np.random.default_rng(0).normal(size=(200, 3)) * 2.0
    model = trimesh.Trimesh(points, faces, process=False)
    theirs, distances, _ = trimesh.proximity.closest_point_naive(model, queries)
    found = SurfaceIndex(points, faces).nearest(queries)
    assert found.distances == pytest.approx(distances, abs=1e-9)
    assert found.points == pytest.approx(theirs, abs=1e-7)


def test_a_corner_is_exactly_at_itself():
    points, faces = pebble(24)
    found = SurfaceIndex(points, faces).nearest(points)
    assert found.distances.max() == 0.0
    assert np.array_equal(found.points, points)


def test_the_middle_of_a_sphere_is_equally_far_from_everything():
    ball = trimesh.creation.icosphere(subdivisions=3)
    points, faces = np.array(ball.vertices), np.array(ball.faces)
    found = SurfaceIndex(points, faces).nearest(np.zeros((1, 3)))
    middles = points[faces]
    normal = np.cross(middles[:, 1] - middles[:, 0], middles[:, 2] - middles[:, 0])
    planes = np.einsum("ij,ij->i", normal, middles[:, 0]) / np.linalg.norm(normal, axis=1)
    assert found.distances[0] == pytest.approx(planes.min(), rel=1e-12)


@pytest.mark.parametrize("scale", [1e-150, 1e-30, 1.0, 1e30, 1e99])
def test_any_unit_and_any_distance(scale):
    points, faces = pebble(16)
    queries = np.array([[0.0, 0.0, 5.0], [0.0, 0.0, 1e9], [1e-3, 0.0, 0.0]])
    plain = SurfaceIndex(points, faces).nearest(queries)
    scaled = SurfaceIndex(points * scale, faces).nearest(queries * scale)
    assert scaled.distances / scale == pytest.approx(plain.distances, rel=1e-12)


def test_one_face_no_query_and_no_face():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    index = SurfaceIndex(points, np.array([[0, 1, 2]]))
    assert index.nearest(np.array([[0.25, 0.25, 3.0]])).weights[0] == pytest.approx([0.5, 0.25, 0.25])
    assert len(index.nearest(np.zeros((0, 3))).points) == 0
    with pytest.raises(InputError, match="no faces"):
        SurfaceIndex(points, np.zeros((0, 3), int))


def test_inputs_stay_as_they_are():
    points, faces = pebble(16)
    arrays = (points, faces, points + 0.1)
    before = [array.copy() for array in arrays]
    for array in arrays:
        array.setflags(write=False)
    SurfaceIndex(points, faces).nearest(arrays[2])
    assert all(np.array_equal(one, other) for one, other in zip(arrays, before, strict=True))


def test_a_shared_place_belongs_to_the_first_face_there_however_the_model_is_turned():
    points, faces = pebble(24)
    random = np.random.default_rng(4)
    edges = points[faces[::7, :2]].mean(axis=1)
    queries = np.concatenate([points, edges, 1.5 * points])
    plain = SurfaceIndex(points, faces).nearest(queries)
    assert np.array_equal(
        plain.faces[: len(points)], [np.flatnonzero((faces == i).any(1))[0] for i in range(len(points))]
    )
    for row, (start, end) in some(enumerate(faces[::7, :2])):
        both = (faces == start).any(axis=1) & (faces == end).any(axis=1)
        assert plain.faces[len(points) + row] == np.flatnonzero(both)[0]
    turn = Rotation.random(random_state=random).as_matrix()
    turned = SurfaceIndex(points @ turn, faces).nearest(queries @ turn)
    assert np.mean(turned.faces == plain.faces) > 0.99  # but for places within rounding of an edge
    again = np.einsum("nc,nck->nk", plain.weights, points[faces[plain.faces]])
    assert again == pytest.approx(plain.points, abs=1e-13)
