"""Which frames are swept: those with axes that an embedding keeps apart, but that damage turns."""

from __future__ import annotations

import pytest

from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.frame_sweep import sweep
from meshmark.ownership.points.point_lattice import PointLattice
from tests.keys import KEY
from tests.low_poly import box, prism

POINTS, FACES = prism(16, 6, 3.0)


def swept(points, faces) -> int:
    """Return in how many frames a surface is looked at."""
    surface = surface_of(Mesh(points, faces))
    lattice = PointLattice.keyed(KEY, Label.of_shape(surface.invariants, KEY))
    return len(sweep(Carried.of(surface, surface.frame), surface.frame, lattice))


@pytest.mark.parametrize("wider", [1.0005, 1.002])
def test_axes_of_nearly_equal_moments_are_turned(wider):
    assert swept(POINTS * [wider, 1.0, 1.0], FACES) > 20


def test_axes_that_no_embedding_leaves_so_alike_are_not():
    assert swept(POINTS, FACES) == 0


def test_axes_that_stand_apart_are_not():
    assert swept(*box((6, 5, 4), (3.0, 2.0, 1.3))) == 0
