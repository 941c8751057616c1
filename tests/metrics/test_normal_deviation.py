"""Normal deviation where the angle is known."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.metrics.normal_deviation import normal_deviation_deg
from tests.metrics.test_surface_distance import ball, square
from tests.shapes import pebble


@pytest.mark.parametrize("degrees", [1e-6, 0.5, 30.0, 89.0])
def test_a_plane_that_is_tilted(degrees):
    flat = square()
    angle = np.radians(degrees)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    tilted = flat.with_vertices(flat.vertices @ turn.T)
    assert normal_deviation_deg(flat, tilted) == pytest.approx(degrees, rel=1e-6)


def test_a_surface_turned_over_deviates_by_180_degrees():
    flat = square()
    assert normal_deviation_deg(flat, Mesh(flat.vertices, flat.faces[:, ::-1])) == pytest.approx(180.0)


def test_a_grown_sphere_keeps_its_normals():
    assert normal_deviation_deg(ball(1.0), ball(1.2)) < 0.1


def test_other_triangles_of_the_same_shape_deviate_little():
    coarse, fine = Mesh(*pebble(40)), Mesh(*pebble(64))
    assert normal_deviation_deg(coarse, fine) < 5.0
    assert normal_deviation_deg(coarse, coarse) == 0.0


def test_surfaces_without_area_have_no_normals():
    thread = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]]))
    with pytest.raises(InputError, match="normal"):
        normal_deviation_deg(thread, square())
