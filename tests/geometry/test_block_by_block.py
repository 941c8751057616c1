"""What is computed a block at a time does not depend on how large a block is; bit by bit where it says so."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.marks import ring_shapes, rings
from meshmark.geometry import (
    areas,
    blocks,
    face_neighbours,
    frame,
    invariants,
    sampling,
    stiffness,
    surface_basis,
)
from meshmark.geometry.blocks import append
from meshmark.geometry.corners import corners_of_points
from meshmark.ownership import bumps
from tests.counting import some
from tests.shapes import pebble

POINTS, FACES = pebble(24)
NORMALS = areas.vertex_normals(POINTS, FACES)
FEW = 7


def small_blocks(count: int, size: int = 0):
    """Return blocks of a few rows."""
    return blocks.blocks(count, FEW)


EXACT = {
    "areas": (areas, lambda: np.column_stack(areas.vertex_area_sums(POINTS, FACES))),
    "stiffness": (stiffness, lambda: stiffness.stiffness(POINTS, FACES).toarray()),
    "samples": (sampling, lambda: sampling.plan_samples(POINTS, FACES, 0.2)(POINTS).vectors),
    "basis": (surface_basis, lambda: surface_basis.surface_basis(POINTS, NORMALS, 0.3).toarray()),
    "frame gradient": (bumps, lambda: bumps.frame_gradient(POINTS, FACES, NORMALS)),
    "neighbours": (
        face_neighbours,
        lambda: np.column_stack(face_neighbours.face_neighbours(FACES, len(POINTS))),
    ),
    "rings": (
        rings,
        lambda: np.concatenate([g.around.ravel() for g in rings.ordered_rings(FACES, len(POINTS))]),
    ),
    "shapes": (
        ring_shapes,
        lambda: np.concatenate(
            [ring_shapes.ring_shapes(POINTS, g).spread for g in rings.ordered_rings(FACES, len(POINTS))]
        ),
    ),
}
SUMS = {
    "moments": (frame, lambda: frame.canonical_frame(POINTS, FACES).moments),
    "invariants": (invariants, lambda: invariants.shape_invariants(POINTS, FACES)),
}


@pytest.mark.parametrize("name", EXACT)
def test_small_blocks_give_the_same_bits(name, monkeypatch):
    module, value = EXACT[name]
    before = value()
    monkeypatch.setattr(module, "blocks", small_blocks)
    np.testing.assert_array_equal(value(), before)


@pytest.mark.parametrize("name", SUMS)
def test_sums_in_small_blocks_differ_by_rounding_alone(name, monkeypatch):
    module, value = SUMS[name]
    before = value()
    monkeypatch.setattr(module, "blocks", small_blocks)
    np.testing.assert_allclose(value(), before, rtol=1e-12)


def test_sums_at_points_are_those_of_a_loop():
    values = np.random.default_rng(0).normal(size=(len(FACES), 2))
    expected = np.zeros((len(POINTS), 2))
    for value, face in zip(values, FACES, strict=True):
        for corner in face:
            expected[corner] += value
    np.testing.assert_array_equal(areas.sum_at_points(values, FACES, len(POINTS)), expected)


def test_without_the_private_function_of_scipy_the_sums_are_the_same(monkeypatch):
    values = np.random.default_rng(0).normal(size=len(FACES))
    before = areas.sum_at_points(values, FACES, len(POINTS))
    monkeypatch.setattr(areas, "csc_matvecs", None)
    np.testing.assert_array_equal(areas.sum_at_points(values, FACES, len(POINTS)), before)


def test_the_corners_of_a_point_come_in_the_order_of_the_faces():
    starts, face, slot = corners_of_points(FACES, len(POINTS))
    for point in some(range(0, len(POINTS), 50)):
        part = slice(starts[point], starts[point + 1])
        rows, columns = np.nonzero(point == FACES)
        np.testing.assert_array_equal(face[part], rows)
        np.testing.assert_array_equal(slot[part], columns)


def test_an_array_gets_longer_in_place():
    whole = np.arange(6.0).reshape(2, 3).copy()
    append(whole, np.full((2, 3), 7.0))
    np.testing.assert_array_equal(whole, [[0, 1, 2], [3, 4, 5], [7, 7, 7], [7, 7, 7]])
