"""Parts of coarse models are registered by the triangles that are left of them."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keyed import rotation
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.registration.corner_matching import MOST_CORNERS, corners_to_keep, match_corners
from meshmark.geometry.similarity import Similarity
from tests.low_poly import ball, frustum, prism, table

SHAPES = {"ball": ball(2), "frustum": frustum(), "table": table()}
MOVE = Similarity(
    scale=37.0, rotation=rotation(b"a turn of a coarse model, 32 by.."), shift=np.array([5.0, -80.0, 3.0])
)


def kept(shape):
    """Return the corners of a shape in its canonical frame, and its canonical points."""
    points, faces = shape
    canonical = canonical_frame(points, faces).to_canonical(points)
    return corners_to_keep(canonical, faces), canonical


def part(faces, points, share):
    """Return the faces without the nearest to the first, of which so large a share is gone."""
    middles = points[faces].mean(axis=1)
    away = np.linalg.norm(middles - middles[0], axis=1)
    return faces[away > np.quantile(away, share)]


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("share", [0.1, 0.3])
def test_a_part_that_was_moved_is_found_where_it_lies(name, share):
    corners, canonical = kept(SHAPES[name])
    moved = MOVE(canonical)
    noise = np.random.default_rng(3).uniform(-1.0, 1.0, moved.shape) * 1e-4 * MOVE.scale
    left = part(SHAPES[name][1], moved, share)
    found = match_corners(corners, moved + noise, left)
    places = corners.reshape(-1, 3)
    off = [np.sqrt(np.mean((each(places) - MOVE(places)) ** 2)) / MOVE.scale for each in found]
    assert min(off) < 2e-3  # a symmetric shape lies in several ways


@pytest.mark.parametrize("seed", range(4))
def test_of_the_ways_in_which_a_nearly_symmetric_shape_lies_the_exact_one_comes_first(seed):
    """A prism of 30 sides, moved as little as a mark does, finds as many corners in every turn by 12 degrees."""
    points, faces = prism(30, 6, 3.0)
    points = points + np.random.default_rng(seed).uniform(-1e-3, 1e-3, points.shape)
    corners, canonical = kept((points, faces))
    found = match_corners(corners, MOVE(canonical), part(faces, canonical, 0.5))
    places = corners.reshape(-1, 3)
    off = [np.sqrt(np.mean((each(places) - MOVE(places)) ** 2)) / MOVE.scale for each in found]
    assert off[0] < 1e-6
    assert len(off) > 1, "it lies in other ways as well"


def test_another_model_is_not_found():
    corners, _ = kept(SHAPES["frustum"])
    points, faces = prism(30, 6, 3.0)
    assert match_corners(corners, points, faces) == []


def test_the_largest_faces_are_kept_and_some_of_most_sizes():
    points, faces = SHAPES["ball"]
    corners = corners_to_keep(points, faces)
    area = np.linalg.norm(np.cross(*np.moveaxis(points[faces][:, 1:] - points[faces][:, :1], 1, 0)), axis=1)
    half = MOST_CORNERS // 2
    of_corners = np.linalg.norm(np.cross(*np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 0)), axis=1)
    assert len(corners) == MOST_CORNERS
    assert np.allclose(np.sort(of_corners)[-half:], np.sort(area)[-half:])
    assert np.quantile(area, 0.2) <= of_corners.min() <= np.quantile(area, 0.3)


def test_without_area_nothing_is_found():
    corners, _ = kept(SHAPES["table"])
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    assert match_corners(corners, points, np.array([[0, 1, 2]])) == []
