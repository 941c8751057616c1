"""Parts of their own that are gone or new, and how much of a surface is missing."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.payload.signed_totals import SIZE, Whole, unmarked_parts, whole_of
from meshmark.geometry.areas import face_areas
from meshmark.geometry.weld import weld
from meshmark.marking import authenticate, embed, recover
from meshmark.mesh import Mesh
from tests.keys import ID, KEY
from tests.shapes import pebble


def pair() -> Mesh:
    """Return two shapes of their own, the second a third as large."""
    points, faces = pebble()
    small, others = pebble(20)
    return Mesh(
        np.concatenate([points, small / 3.0 + np.array([4.0, 0.0, 0.0])]),
        np.concatenate([faces, others + len(points)]),
    )


@pytest.fixture(scope="module")
def marked() -> Mesh:
    return embed(pair(), KEY, id=ID, layers="authentication").mesh


def middle(mesh: Mesh, count: int) -> np.ndarray:
    """Return the centroid of the surface of vertices from `count` on."""
    faces = mesh.faces[(mesh.faces >= count).all(axis=1)]
    return np.average(mesh.vertices[faces].mean(axis=1), axis=0, weights=face_areas(mesh.vertices, faces))


def test_a_shell_that_is_gone_is_missed(marked):
    count = len(pebble()[0])
    left = Mesh(marked.vertices[:count], marked.faces[(marked.faces < count).all(axis=1)])
    assert authenticate(marked, KEY).points_missing == 0
    found = authenticate(left, KEY)
    assert (found.verdict, found.points_missing) == ("altered", len(marked.vertices) - count)
    areas = face_areas(marked.vertices, marked.faces)
    gone = areas[(marked.faces >= count).all(axis=1)].sum() / areas.sum()
    assert found.missing_area_fraction == pytest.approx(gone, abs=0.03)
    assert f"{found.points_missing:,} points" in found.advice
    back = recover(left, KEY)
    assert back.mesh is not None
    assert "missing parts are back" in back.advice
    assert np.array_equal(back.mesh.vertices[:count], left.vertices)
    shell = marked.vertices[count:]
    assert np.allclose(np.ptp(back.mesh.vertices[count:], axis=0), np.ptp(shell, axis=0), atol=0.05)
    assert np.allclose(middle(back.mesh, count), middle(marked, count), atol=0.06)


def test_what_the_miniature_does_not_have_is_not_brought_back():
    mesh = embed(pair(), KEY, id=ID, layers="authentication", payload="none").mesh
    count = len(pebble()[0])
    back = recover(Mesh(mesh.vertices[:count], mesh.faces[(mesh.faces < count).all(axis=1)]), KEY)
    assert back.mesh is None
    assert "no miniature" in back.advice


def test_a_part_too_fine_for_marks_that_is_added_is_seen(marked):
    small, faces = pebble(16)
    speck = 1e-5 * small + np.array([0.0, 3.0, 0.0])
    more = Mesh(
        np.concatenate([marked.vertices, speck]),
        np.concatenate([marked.faces, faces + len(marked.vertices)]),
    )
    found = authenticate(more, KEY)
    assert (found.verdict, found.points_missing) == ("altered", -len(small))
    assert found.altered[len(marked.vertices) :].all()
    assert not found.altered[: len(marked.vertices)].any()


def test_what_is_missing_of_a_surface_is_measured(marked):
    middles = marked.vertices[marked.faces].mean(axis=1)
    gone = np.linalg.norm(middles - middles[100], axis=1) < 0.6
    turned = Mesh(2.5 * marked.vertices[:, [1, 2, 0]] + 1.0, marked.faces[~gone])
    found = authenticate(turned, KEY)
    areas = face_areas(marked.vertices, marked.faces)
    assert found.verdict == "altered"
    assert found.missing_area_fraction == pytest.approx(areas[gone].sum() / areas.sum(), abs=0.02)
    assert "of the signed-off surface is missing" in found.advice


def test_holes_are_closed_and_one_that_meets_the_own_border_is_said_to_stay():
    points, faces = pebble()
    middles = points[faces].mean(axis=1)
    faces = faces[middles[:, 2] < 0.9 * middles[:, 2].max()]
    whole = embed(Mesh(points, faces), KEY, id=ID, layers="authentication").mesh
    middles = whole.vertices[whole.faces].mean(axis=1)
    for place, added in ((middles[:, 2].argmin(), True), (middles[:, 2].argmax(), False)):
        gone = np.linalg.norm(middles - middles[place], axis=1) < 0.4
        found = recover(Mesh(whole.vertices, whole.faces[~gone]), KEY)
        assert (found.mesh is not None, found.faces_added > 0) == (added, added)
        assert ("left open" in found.advice) == (not added)


def test_packing_round_trips_and_points_too_near_are_not_counted():
    points, faces = pebble(16)
    surface = weld(Mesh(points, faces))
    whole = whole_of(surface, 1e-6)
    assert whole.points == len(points)
    assert len(whole.packed()) == SIZE
    again, rest = Whole.read(whole.packed() + b"more", copies=False, shown=False, once=False)
    assert rest == b"more"
    assert (again.points, again.area) == (whole.points, pytest.approx(whole.area, rel=1e-6))
    assert whole_of(surface, 1.0).points == 0


def test_parts_without_a_verified_point():
    mesh = pair()
    surface = weld(mesh)
    verified = np.zeros(len(surface.points), bool)
    verified[3] = True
    alone = unmarked_parts(surface, verified)
    assert np.array_equal(np.flatnonzero(alone), np.arange(len(pebble()[0]), len(mesh.vertices)))
