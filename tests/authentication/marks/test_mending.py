"""A plan is mended near points that are left without a mark that is read, and stays as it is elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.checks.checks import check
from meshmark.authentication.marks.mending import Doubts, mended
from meshmark.authentication.marks.plan import Plan, mark, plan
from meshmark.authentication.marks.precision import precision_of
from meshmark.authentication.parameters import FINE
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.counting import some
from tests.keys import ID, KEY
from tests.shapes import pebble


@pytest.fixture(scope="module")
def planned() -> Plan:
    mesh = Mesh(*pebble(56))
    return plan(weld(mesh), KEY, precision_of(mesh))


def _at(plan: Plan, points: list[int]) -> np.ndarray:
    chosen = np.zeros(len(plan.surface.points), bool)
    chosen[points] = True
    return chosen


def _unread(points: np.ndarray, ever: np.ndarray | None = None, failing: np.ndarray | None = None) -> Doubts:
    """Doubts about points (p,) that are unread now; nothing else is known unless it is given."""
    no = np.zeros(len(points), bool)
    return Doubts(
        unread=points,
        ever=points if ever is None else points | ever,
        failing=no if failing is None else failing,
    )


def _distance(plan: Plan, start: np.ndarray) -> np.ndarray:
    """Edges from the nearest of the points `start` (p,), 9 where there are more."""
    distance, reached = np.where(start, 0, 9), start
    for step in range(1, 9):
        reached = reached | (plan.surface.graph @ reached.astype(float) > 0.0)
        distance = np.where(reached, np.minimum(distance, step), distance)
    return distance


def test_marks_far_from_the_point_stay_and_those_next_to_it_go(planned):
    for point in some([int(planned.marks[7]), int(planned.surface.graph[[planned.marks[20]]].indices[0])]):
        unread = _at(planned, [point])
        again = mended(planned, KEY, _unread(unread), FINE)
        distance = _distance(planned, unread)
        before, after = (_at(planned, list(each.marks)) for each in (planned, again))
        assert not (before & after & (distance <= 1)).any()
        assert (before == after)[distance > 4].all()
        assert (after & (distance <= 1)).any()


def test_the_marks_stay_a_maximal_set_without_neighbours_and_are_read(planned):
    unread = _at(planned, planned.marks[::40].tolist())
    again = mended(planned, KEY, _unread(unread), FINE)
    chosen, edges = _at(planned, list(again.marks)), planned.surface.edges
    assert len(np.unique(again.marks)) == len(again.marks)
    assert not chosen[edges].all(axis=1).any()
    done = mark(again, KEY, ID, lambda index: (index & np.uint32(15)).astype(np.uint16))
    found = check(weld(Mesh(done.points, planned.surface.faces)), KEY)
    assert found.nonce == ID
    assert found.passed[again.marks].all()
    assert not (found.eligible & ~found.verified).any()


def test_mending_repeats(planned):
    unread = _at(planned, [5, 100])
    one, other = (mended(planned, KEY, _unread(unread), FINE) for _ in range(2))
    assert np.array_equal(one.marks, other.marks)


def test_a_point_that_was_unread_before_keeps_a_mark_that_is_read(planned):
    """All its neighbours but one fail; then marks next to other points near that one are chosen anew."""
    graph, lost = planned.surface.graph, 0
    for point in some(range(50, 1500, 150)):
        ring = graph[[point]].indices
        wanted = int(np.setdiff1d(ring, planned.marks)[0])
        failing = _at(planned, [point, *ring])
        failing[wanted] = False
        first = mended(planned, KEY, _unread(_at(planned, [point]), failing=failing), FINE)
        assert wanted in first.marks
        distance = _distance(planned, _at(planned, [wanted]))
        for other in some(np.flatnonzero(distance == 2)):
            unread = _at(planned, [int(other)])
            remembered = _unread(unread, ever=_at(planned, [point]), failing=failing)
            assert wanted in mended(first, KEY, remembered, FINE).marks
            lost += wanted not in mended(first, KEY, _unread(unread, failing=failing), FINE).marks
    assert lost > 0  # by some of these choices, where what was unread before is forgotten
