"""Which shapes a suspect may have had, and in which frames they are read."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.frame import Frame
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.search.restoration import Shape, restorations
from meshmark.ownership.search.shapes import Shapes
from tests.counting import some
from tests.shapes import pebble

POINTS, FACES = pebble(96)
SIZE = float(np.linalg.norm(np.ptp(POINTS, axis=0)))


def noisy():
    noise = np.random.default_rng(1).normal(size=POINTS.shape)
    return surface_of(Mesh(POINTS + 0.006 * SIZE * noise, FACES))


def apart(one: Frame, other: Frame) -> float:
    """Return how far two frames put the points of the pebble from one another (RMS, canonical units)."""
    return float(np.sqrt(np.mean((one.to_canonical(POINTS) - other.to_canonical(POINTS)) ** 2)))


def test_the_first_shape_is_the_surface_as_it_stands_in_its_own_frame():
    surface = noisy()
    (first,) = next(restorations(surface)).shapes
    np.testing.assert_array_equal(first.points, surface.points)
    assert first.framed_by is None


def test_shapes_of_another_frame_lie_in_it():
    surface = noisy()
    shapes = Shapes(surface)
    found = [restoration.shapes[0] for restoration in restorations(surface)]
    for shape in some(shape for shape in found if shape.framed_by is not None):
        assert shapes.frame(shape) is shapes.frame(shape.framed_by)
        assert shapes.frame(shape) is not shapes.frame(Shape(shape.points))


def test_a_smoother_shape_has_nearly_the_frame_from_before_the_noise():
    surface = noisy()
    shapes, before = Shapes(surface), surface_of(Mesh(POINTS, FACES)).frame
    framed = next(
        restoration.shapes[0] for restoration in restorations(surface) if restoration.shapes[0].framed_by
    )
    assert apart(shapes.frame(framed), before) < 0.5 * apart(surface.frame, before)


def test_where_the_frame_is_known_no_shape_is_read_twice():
    surface = noisy()
    own, known = (
        [restoration.shapes[0].points for restoration in restorations(surface, frame_known=given)]
        for given in (False, True)
    )
    assert sum(np.array_equal(points, surface.points) for points in own) == 2
    assert sum(np.array_equal(points, surface.points) for points in known) == 1
    assert len(own) == len(known) + 1


def test_a_shape_that_filtering_shrinks_to_nothing_is_no_frame():
    """In its frame the surface would be a hundred times as large, of so many cells that memory runs out."""
    triangle = surface_of(
        Mesh(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.array([[0, 1, 2]]))
    )
    shapes = Shapes(triangle)
    for restoration in some(restorations(triangle)):
        for shape in some(restoration.shapes):
            assert shape.framed_by is None
            assert np.abs(shapes.frame(shape).to_canonical(shape.points)).max() < 3.0


def test_low_passed_shapes_are_left_out_where_the_filters_move_the_frame():
    """On a coarse mesh a filter takes the frame further than any noise that a mark bears."""
    coarse = surface_of(Mesh(*pebble(20)))
    blind, known = (list(restorations(coarse, frame_known=given)) for given in (False, True))
    assert [len(each.shapes) for each in blind] == [1, 2, 2, 2, 2]
    assert [len(each.shapes) for each in known] == [1, 1, 2, 2, 2, 2, 1]


def test_a_surface_is_not_read_again_in_the_same_frame():
    smooth = surface_of(Mesh(POINTS, FACES))
    found = [each.shapes[0] for each in restorations(smooth)]
    assert sum(np.array_equal(shape.points, smooth.points) for shape in found) == 1
    assert [shape.framed_by for shape in found if shape.framed_by is not None] == [found[-1]]


def test_invariants_of_the_middle_lie_between_those_of_the_ends():
    surface = noisy()
    shapes = Shapes(surface)
    pairs = [found for found in restorations(surface) if len(found.shapes) == 2]
    for pair in some(pairs):
        one, other = (shapes.invariants(shape) for shape in pair.shapes)
        np.testing.assert_allclose(shapes.middle_invariants(pair), (one + other) / 2, rtol=1e-12)
    alone = next(restorations(surface))
    np.testing.assert_array_equal(shapes.middle_invariants(alone), shapes.invariants(alone.shapes[0]))
