"""Parts of an assembly with both layers: each tells the id when taken out, and only those that do are counted."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from meshmark.coding.keyed import rotation
from meshmark.marking import Embedding, embed, extract
from meshmark.marking.marked_parts import parts_in_words, parts_read
from meshmark.mesh import FloatArray, Mesh
from tests.keys import ID, KEY, OTHER
from tests.low_poly import joined
from tests.shapes import pebble

# Two parts of some 400 points, and one that is too small to tell the id by itself.
PIECES = [
    (size * pebble(across)[0] + shift, pebble(across)[1])
    for across, size, shift in ((32, 1.0, 0.0), (28, 0.6, 4.0), (18, 0.5, 8.0))
]
SIZES = [len(points) for points, _ in PIECES]


@cache
def marked() -> Embedding:
    return embed(Mesh(*joined(PIECES)), KEY, id=ID)


def piece(number: int) -> slice:
    return slice(sum(SIZES[:number]), sum(SIZES[: number + 1]))


def elsewhere(positions: FloatArray, number: int) -> Mesh:
    """Return one part by itself, turned, scaled and shifted, its faces in another order, in single precision."""
    moved = positions[piece(number)] @ rotation(b"elsewhere" * 4).T * 12.0 + [3.0, -1.0, 2.0]
    faces = PIECES[number][1]
    order = np.random.default_rng(3).permutation(len(faces))
    return Mesh(moved.astype(np.float32).astype(np.float64), faces[order])


@pytest.mark.parametrize("number", [0, 1])
def test_each_large_part_tells_the_id_when_it_is_taken_out(number: int) -> None:
    assert marked().layers == "both"
    assert marked().remarks[-1].startswith("2 parts carry the id by themselves")
    part = elsewhere(marked().mesh.vertices, number)
    assert extract(part, KEY, search="plain").id == ID
    assert extract(part, OTHER, search="plain").presence == "absent"


def test_a_part_without_marks_in_its_points_is_read_by_those_of_authentication() -> None:
    assert parts_read(marked().mesh, KEY, ID, ()) == ((), 2)


def test_only_parts_that_are_read_are_counted() -> None:
    positions = marked().mesh.vertices.copy()
    positions[piece(1)] = PIECES[1][0]
    half = Mesh(positions, marked().mesh.faces)
    at_points, telling = parts_read(half, KEY, ID, (0, 1))
    assert telling == 1
    assert set(at_points) <= {0}
    assert parts_read(half, OTHER, ID, (0, 1)) == ((), 0)
    assert parts_read(half, KEY, ID + 1, (0, 1)) == ((), 0)


def test_the_remark_counts() -> None:
    assert parts_in_words(0, 64) == ()
    assert parts_in_words(1, 0)[0].startswith("one part carries the mark by itself")
    assert parts_in_words(3, 32)[0].startswith("3 parts carry the id by themselves")
