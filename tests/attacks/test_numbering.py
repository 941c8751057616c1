"""Other numbers, the same surface."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from meshmark.attacks import ATTACKS
from meshmark.mesh import Mesh
from tests.attacks.models import odd_strip, seam, seamed

MODEL = seamed()


def triangles(mesh: Mesh) -> Counter:
    """The triangles as positions, each from its smallest corner on: independent of all numbers."""
    found = Counter()
    for face in mesh.faces.tolist():
        corners = [tuple(mesh.vertices[v].tolist()) for v in face]
        start = corners.index(min(corners))
        found[tuple(corners[start:] + corners[:start])] += 1
    return found


@pytest.mark.parametrize("name", ["shuffle", "weld", "unweld"])
def test_the_surface_is_the_same_and_the_map_tells_the_numbers(name):
    result = ATTACKS[name].apply(MODEL, 1, np.random.default_rng(1))
    assert triangles(result.mesh) == triangles(MODEL)
    np.testing.assert_array_equal(result.mesh.vertices, MODEL.vertices[result.origin])


def test_shuffle_moves_vertices_faces_and_first_corners():
    result = ATTACKS["shuffle"].apply(MODEL, 1, np.random.default_rng(1))
    assert sorted(result.origin.tolist()) == list(range(len(MODEL.vertices)))
    numbered = result.origin[result.mesh.faces]
    place = {frozenset(face): row for row, face in enumerate(MODEL.faces.tolist())}
    rows = np.array([place[frozenset(face)] for face in numbered.tolist()])
    starts = np.array(
        [MODEL.faces[row].tolist().index(face[0]) for row, face in zip(rows, numbered, strict=True)]
    )
    assert sorted(rows.tolist()) == list(range(len(MODEL.faces)))
    assert abs(np.corrcoef(rows, np.arange(len(rows)))[0, 1]) < 4.5 / np.sqrt(len(rows))
    assert abs(np.corrcoef(result.origin, np.arange(len(result.origin)))[0, 1]) < 4.5 / np.sqrt(
        len(result.origin)
    )
    share = np.bincount(starts, minlength=3) / len(starts)
    np.testing.assert_allclose(share, 1 / 3, atol=4.5 * np.sqrt(2 / 9 / len(starts)))


def test_weld_leaves_one_vertex_in_each_place():
    result = ATTACKS["weld"](MODEL, 1, np.random.default_rng(1))
    places = {tuple(row) for row in MODEL.vertices.tolist()}
    assert len(result.vertices) == len(places) == len({tuple(row) for row in result.vertices.tolist()})
    assert not len(seam(result)[0])


def test_unweld_gives_every_corner_its_own_vertex_and_keeps_lone_ones():
    mesh = odd_strip()
    result = ATTACKS["unweld"].apply(mesh, 1, np.random.default_rng(1))
    np.testing.assert_array_equal(result.mesh.faces.ravel(), np.arange(mesh.faces.size))
    assert result.origin.tolist() == [*mesh.faces.ravel().tolist(), len(mesh.vertices) - 1]


def test_weld_undoes_unweld():
    rng = np.random.default_rng(1)
    welded = ATTACKS["weld"](MODEL, 1, rng)
    again = ATTACKS["weld"](ATTACKS["unweld"](welded, 1, rng), 1, rng)
    assert triangles(again) == triangles(welded)
    assert len(again.vertices) == len(welded.vertices)
