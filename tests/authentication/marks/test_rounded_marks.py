"""Who made the marks finds without a search what an examination of the rounded model finds."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.checks.checks import check
from meshmark.authentication.checks.rounded_marks import unread_when_rounded
from meshmark.authentication.marks.mending import Doubts, mended
from meshmark.authentication.marks.plan import Marked, Plan, mark, plan
from meshmark.authentication.marks.precision import precision_of
from meshmark.authentication.parameters import FINE
from meshmark.coding.keyed import rotation
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.keys import ID, KEY
from tests.shapes import pebble

FACTOR = 9.0
"""How much more coarsely than the marks bear the model is rounded."""


@pytest.fixture(scope="module")
def planned() -> Plan:
    mesh = Mesh(*pebble(70))
    return plan(weld(mesh), KEY, precision_of(mesh))


@pytest.fixture(scope="module")
def marked(planned: Plan) -> Marked:
    return mark(planned, KEY, ID, lambda index: (index & np.uint32(15)).astype(np.uint16))


def _rounded(planned: Plan, marked: Marked, factor: float) -> np.ndarray:
    step = factor * planned.unit / FINE.unit
    return np.round(marked.points / step) * step


def test_what_is_unread_is_what_a_check_finds(planned, marked):
    points = _rounded(planned, marked, FACTOR)
    unread, failing = unread_when_rounded(planned, marked, points, KEY, FINE)
    found = check(weld(Mesh(points, planned.surface.faces)), KEY, ID)
    altered = found.eligible & ~found.verified
    assert altered.sum() > 20
    assert (unread & altered).sum() >= 0.9 * altered.sum()
    assert unread.sum() <= 2.0 * altered.sum()  # a check tries so many ways that some hold by luck
    assert failing.sum() > unread.sum() / 8
    assert np.isin(np.flatnonzero(failing), planned.marks).all()


@pytest.mark.parametrize("factor", [0.0001, 1.0])
def test_all_are_read_where_the_rounding_is_what_the_marks_are_made_for(planned, marked, factor):
    unread, failing = unread_when_rounded(planned, marked, _rounded(planned, marked, factor), KEY, FINE)
    assert not unread.any()
    assert failing.mean() < 0.002


def test_a_similarity_transform_may_come_first(planned, marked):
    moved = 0.15 * marked.points @ rotation(b"r" * 32).T + 3.0
    assert not unread_when_rounded(planned, marked, moved, KEY, FINE)[0].any()


def test_points_of_marks_that_fail_are_avoided_when_a_plan_is_mended(planned):
    unread, avoid = np.zeros((2, len(planned.surface.points)), bool)
    unread[planned.marks[::50]] = True
    beside = np.flatnonzero((planned.surface.graph @ unread.astype(float) > 0.0) & ~unread)
    avoid[beside[::2]] = True
    added = [
        np.setdiff1d(
            mended(planned, KEY, Doubts(unread=unread, ever=unread, failing=some), FINE).marks, planned.marks
        )
        for some in (np.zeros(len(avoid), bool), avoid)
    ]
    likely, avoided = (int(avoid[new].sum()) for new in added)
    assert likely > 10
    assert avoided < likely / 2


def test_marks_fail_as_in_a_check_where_a_part_is_rounded_more_than_the_rest(planned, marked):
    x = marked.points[:, 0]
    rough, fine = (_rounded(planned, marked, factor) for factor in (10.0, 0.7))
    points = np.where((x > np.quantile(x, 0.8))[:, None], rough, fine)
    _, failing = unread_when_rounded(planned, marked, points, KEY, FINE)
    passed = check(weld(Mesh(points, planned.surface.faces)), KEY, ID).passed
    missed = planned.marks[~passed[planned.marks]]
    assert len(missed) > 40
    assert failing[missed].mean() >= 0.8
    assert failing.sum() <= 1.1 * len(missed)
