"""A part put on: closed, of the size that was asked for, where the generator says, and nothing else moved."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks.attack import Given
from meshmark.attacks.local_add import FEWEST, SUNK, UNEVEN, add_part
from meshmark.attacks.local_patch import draw_patch
from meshmark.errors import InputError
from meshmark.geometry.areas import face_areas
from meshmark.mesh import Mesh
from tests.attacks.surfaces import euler, is_closed, volume
from tests.shapes import pebble

MESH = Mesh(*pebble(30))
COUNT = len(MESH.vertices)


def added(share, mesh=MESH, seed=3):
    result = add_part(mesh, share, np.random.default_rng(seed), Given())
    new = Mesh(
        result.mesh.vertices[len(mesh.vertices) :], result.mesh.faces[len(mesh.faces) :] - len(mesh.vertices)
    )
    return result, new


@pytest.mark.parametrize("share", [0.001, 0.05, 0.3])
def test_the_new_piece_is_closed_faces_outwards_and_has_the_share_of_points_and_area(share):
    result, new = added(share)
    assert is_closed(new)
    assert euler(new) == 2
    assert volume(new) > 0.0
    assert len(new.vertices) == max(round(share * COUNT), FEWEST)
    area = face_areas(new.vertices, new.faces).sum() / face_areas(MESH.vertices, MESH.faces).sum()
    assert area == pytest.approx(share, rel=0.5)
    np.testing.assert_array_equal(result.mesh.vertices[:COUNT], MESH.vertices)
    np.testing.assert_array_equal(result.mesh.faces[: len(MESH.faces)], MESH.faces)
    np.testing.assert_array_equal(np.flatnonzero(result.altered), np.arange(COUNT, len(result.mesh.vertices)))
    np.testing.assert_array_equal(result.origin[result.altered], -1)
    np.testing.assert_array_equal(result.origin[:COUNT], np.arange(COUNT))


def test_it_lies_on_the_surface_half_sunk():
    patch = draw_patch(MESH, 0.05, np.random.default_rng(3))
    _, new = added(0.05)
    radius = np.sqrt(0.05 * face_areas(MESH.vertices, MESH.faces).sum() / (4.0 * np.pi))
    off = np.linalg.norm(new.vertices - patch.points[0] - SUNK * radius * patch.normal, axis=1) / radius
    assert off.min() >= 1.0 - UNEVEN - 1e-9
    assert off.max() <= 1.0 + UNEVEN + 1e-9
    side = (new.vertices - patch.points[0]) @ patch.normal
    assert side.min() < 0.0 < side.max()


def test_any_unit_gives_the_same_piece():
    _, here = added(0.05)
    _, there = added(0.05, Mesh(MESH.vertices * 2.0**90, MESH.faces))
    np.testing.assert_array_equal(there.faces, here.faces)
    np.testing.assert_allclose(there.vertices / 2.0**90, here.vertices, rtol=0, atol=1e-9)


def test_a_model_without_area_is_refused():
    with pytest.raises(InputError, match="no area"):
        added(0.5, Mesh(np.arange(4.0)[:, None] * [1.0, 0.0, 0.0], [[0, 1, 2], [1, 2, 3]]))
