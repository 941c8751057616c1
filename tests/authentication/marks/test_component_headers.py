"""Marks that tell the id in every large component: planned, written, and read from a component taken out."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import meshmark.authentication.marks.plan as planning
from meshmark.authentication.checks.marked_ids import marked_ids
from meshmark.authentication.marks.candidates import HEADER
from meshmark.authentication.marks.plan import Plan, mark, plan
from meshmark.authentication.marks.precision import precision_of
from meshmark.authentication.marks.symbols import pieces_of_id
from meshmark.coding.keyed import rotation
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.counting import some
from tests.keys import ID, KEY
from tests.low_poly import joined
from tests.shapes import pebble

# Two components of some 400 points, and one that is too small to tell the id by itself.
PIECES = [
    (size * pebble(across)[0] + shift, pebble(across)[1])
    for across, size, shift in ((32, 1.0, 0.0), (28, 0.6, 4.0), (18, 0.5, 8.0))
]
LARGE = 2


def of_piece(number: int) -> slice:
    sizes = [len(points) for points, _ in PIECES]
    return slice(sum(sizes[:number]), sum(sizes[: number + 1]))


def planned(pieces: list[tuple[NDArray[np.float64], NDArray[np.int64]]]) -> Plan:
    mesh = Mesh(*joined(pieces))
    return plan(weld(mesh), KEY, precision_of(mesh))


def carried(made: Plan, number: int) -> NDArray[np.int64]:
    """Return how many marks with rings that are unlike carry each piece of the id in a component."""
    header = made.found.take(made.found.kind == HEADER)
    own = header.take((header.vertex >= of_piece(number).start) & (header.vertex < of_piece(number).stop))
    unlike = own.take(np.unique(own.name, return_index=True)[1])
    pieces = pieces_of_id(made.layout.symbol)
    return np.bincount(unlike.index.astype(np.int64) % pieces, minlength=pieces)


def nothing_first(surface: Surface, *_: object, **__: object) -> NDArray[np.bool_]:
    return np.zeros(len(surface.points), bool)


def test_each_large_component_carries_pieces_that_it_would_lack(monkeypatch: pytest.MonkeyPatch) -> None:
    made = planned(PIECES)
    monkeypatch.setattr(planning, "headers_first", nothing_first)
    before = planned(PIECES)
    for number in some(range(LARGE)):
        assert np.count_nonzero(carried(made, number)) > np.count_nonzero(carried(before, number))
        assert carried(made, number).sum() >= 1.5 * carried(before, number).sum()
    assert (carried(made, LARGE) == carried(before, LARGE)).all(), "too small"
    assert len(made.marks) > 0.95 * len(before.marks)
    assert made.covered > before.covered - 0.01


def test_no_two_marks_are_neighbours() -> None:
    made = planned(PIECES)
    chosen = np.zeros(len(made.surface.points), bool)
    chosen[made.marks] = True
    assert not chosen[made.surface.connectivity.edges].all(axis=1).any()


def test_the_marks_of_a_surface_in_one_piece_stay_as_they_were(monkeypatch: pytest.MonkeyPatch) -> None:
    made = planned(PIECES[:1])
    monkeypatch.setattr(planning, "headers_first", nothing_first)
    assert (made.marks == planned(PIECES[:1]).marks).all()


def test_a_component_taken_out_tells_the_id(monkeypatch: pytest.MonkeyPatch) -> None:
    read = {}
    for way in ("first", "as they come"):
        if way == "as they come":
            monkeypatch.setattr(planning, "headers_first", nothing_first)
        done = mark(planned(PIECES), KEY, ID, lambda index: np.zeros(len(index), np.uint16))
        for number in range(LARGE):
            points = done.points[of_piece(number)] @ rotation(b"elsewhere" * 4).T * 12.0
            part = Mesh(points.astype(np.float32).astype(np.float64), PIECES[number][1])
            read[way, number] = [each.id for each in marked_ids(weld(part), KEY)]
    assert [read["first", number] for number in range(LARGE)] == [[ID], [ID]]
    assert [] in [read["as they come", number] for number in range(LARGE)]
