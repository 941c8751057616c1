"""Subdivision against Euler's counts, straight loops over faces, and the grids that each scheme reproduces."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest

from meshmark.attacks.attack import Given
from meshmark.attacks.subdivision import loop, midpoint, sqrt3
from meshmark.errors import InputError
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.attacks.surfaces import area, border, directed, euler, is_closed, sheet, unwelded, volume
from tests.counting import some
from tests.shapes import pebble

ALL = pytest.mark.parametrize("attack", [midpoint, loop, sqrt3])
CLOSED = Mesh(*pebble(16))


def fin() -> Mesh:
    """A bumpy sheet with a border, a fin that stands on an inner edge, and a vertex of no face."""
    points, faces = sheet(4)
    points = points + 0.2 * np.random.default_rng(4).normal(size=points.shape)
    fins = [[12, 13, len(points)], [13, 12, len(points) + 1]]
    return Mesh(
        np.concatenate([points, [[2.0, 1.0, 2.0], [2, 1, -2], [7, 7, 7]]]), np.concatenate([faces, fins])
    )


def subdivided(attack, mesh: Mesh, levels: float = 1):
    return attack(mesh, levels, np.random.default_rng(0), Given())


def neighbours(mesh: Mesh):
    """Return, by straight loops, the faces of each edge and the ring of each vertex."""
    sides, ring = defaultdict(list), defaultdict(set)
    for a, b, c in mesh.faces.tolist():
        for one, other, third in ((a, b, c), (b, c, a), (c, a, b)):
            sides[frozenset((one, other))].append(third)
            ring[one] |= {other, third}
    return sides, ring


@ALL
@pytest.mark.parametrize("levels", [1, 2])
def test_counts_follow_from_the_scheme_and_the_topology_stays(attack, levels):
    result = subdivided(attack, CLOSED, levels).mesh
    assert len(result.faces) == (3 if attack is sqrt3 else 4) ** levels * len(CLOSED.faces)
    assert euler(result) == euler(CLOSED) == 2
    assert is_closed(result)
    assert volume(result) == pytest.approx(volume(CLOSED), rel=0.2)
    # A closed triangle mesh has as many vertices as its characteristic and its faces say.
    assert len(result.vertices) == 2 + len(result.faces) // 2


@ALL
def test_old_vertices_keep_their_numbers_and_new_ones_have_none(attack):
    result = subdivided(attack, CLOSED, 2)
    count = len(CLOSED.vertices)
    np.testing.assert_array_equal(result.origin[:count], np.arange(count))
    assert (result.origin[count:] == -1).all()
    assert result.altered is None
    assert result.mesh.document is None


def test_midpoint_leaves_the_surface_as_it_is():
    mesh = fin()
    result = subdivided(midpoint, mesh, 2).mesh
    assert area(result) == pytest.approx(area(mesh), rel=1e-12)
    np.testing.assert_array_equal(result.vertices[: len(mesh.vertices)], mesh.vertices)
    once = subdivided(midpoint, mesh).mesh
    middles = {tuple(mesh.vertices[list(edge)].mean(axis=0)) for edge in neighbours(mesh)[0]}
    assert {tuple(row) for row in once.vertices[len(mesh.vertices) :]} == middles


@pytest.mark.parametrize("mesh", [fin(), CLOSED], ids=["fin", "closed"])
def test_loop_against_a_straight_loop(mesh):
    sides, ring = neighbours(mesh)
    points, boundary = mesh.vertices, defaultdict(list)
    odd = []
    for edge, third in sides.items():
        a, b = edge
        middle = 0.5 * (points[a] + points[b])
        if len(third) == 2:
            odd.append(0.375 * (points[a] + points[b]) + 0.125 * points[third].sum(axis=0))
        else:
            odd.append(middle)
            boundary[a].append(b)
            boundary[b].append(a)
    even = points.copy()
    for vertex, around in ring.items():
        n = len(around)
        if len(boundary[vertex]) == 2:
            even[vertex] = 0.75 * points[vertex] + 0.125 * points[boundary[vertex]].sum(axis=0)
        elif not boundary[vertex]:
            beta = (0.625 - (0.375 + 0.25 * np.cos(2 * np.pi / n)) ** 2) / n
            even[vertex] = (1 - n * beta) * points[vertex] + beta * points[list(around)].sum(axis=0)
    result = subdivided(loop, mesh).mesh
    np.testing.assert_allclose(result.vertices[: len(points)], even, atol=1e-14)
    order = np.lexsort(result.vertices[len(points) :].round(9).T)
    expected = np.array(odd)[np.lexsort(np.round(odd, 9).T)]
    np.testing.assert_allclose(result.vertices[len(points) :][order], expected, atol=1e-14)


def test_root_three_against_a_straight_loop():
    mesh = fin()
    points, walked = mesh.vertices, directed(mesh)
    middle_of = {}
    for number, (a, b, c) in enumerate(mesh.faces.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            middle_of[edge] = len(points) + number
    expected, fixed = set(), set()
    for number, (a, b, c) in enumerate(mesh.faces.tolist()):
        for one, other in ((a, b), (b, c), (c, a)):
            inner = walked[one, other] == walked[other, one] == 1
            end = middle_of[other, one] if inner else other
            fixed |= set() if inner else {one, other}
            expected.add((one, end, len(points) + number))
    result = subdivided(sqrt3, mesh).mesh
    assert {tuple(face) for face in result.faces.tolist()} == expected
    np.testing.assert_allclose(result.vertices[len(points) :], points[mesh.faces].mean(axis=1), atol=1e-14)
    for vertex, around in some(neighbours(mesh)[1].items()):
        alpha = (4 - 2 * np.cos(2 * np.pi / len(around))) / 9
        moved = (1 - alpha) * points[vertex] + alpha * points[list(around)].mean(axis=0)
        place = points[vertex] if vertex in fixed else moved
        np.testing.assert_allclose(result.vertices[vertex], place, atol=1e-14)


@ALL
def test_a_plane_stays_a_plane_and_a_regular_grid_stays_regular(attack):
    flat = Mesh(*sheet(6))
    result = subdivided(attack, flat).mesh
    assert (result.vertices[:, 2] == 0.0).all()
    assert area(result) == pytest.approx(area(flat), rel=0.05 if attack is loop else 1e-12)
    ends = list({frozenset(edge) for edge in directed(result)})
    a, b = result.vertices[np.array([list(edge) for edge in ends])].transpose(1, 0, 2)
    inner = (np.abs(0.5 * (a + b) - flat.vertices.mean(axis=0)) < 1.2).all(axis=1)
    length = np.linalg.norm(a - b, axis=1)[inner]
    np.testing.assert_allclose(length, np.sqrt(1 / 3) if attack is sqrt3 else 0.5, rtol=1e-12)


def test_root_three_keeps_the_border_edges():
    mesh = Mesh(*sheet(4))
    result = subdivided(sqrt3, mesh, 2).mesh
    assert border(result) == border(mesh)


@ALL
def test_seams_close_and_no_unit_matters(attack):
    whole, split = subdivided(attack, CLOSED).mesh, subdivided(attack, unwelded(CLOSED))
    assert is_closed(split.mesh)
    assert volume(split.mesh) == pytest.approx(volume(whole), rel=1e-12)
    seams = weld(unwelded(CLOSED))
    np.testing.assert_array_equal(split.origin[: len(seams.points)], seams.vertex_of_point)
    large = subdivided(attack, Mesh(CLOSED.vertices * 2.0**60, CLOSED.faces)).mesh
    np.testing.assert_array_equal(large.vertices, whole.vertices * 2.0**60)


@ALL
@pytest.mark.parametrize(("levels", "said"), [(1.5, "whole number of levels"), (30, "too many faces")])
def test_other_levels_are_refused(attack, levels, said):
    with pytest.raises(InputError, match=said):
        subdivided(attack, CLOSED, levels)
