"""Forgeries judged by a few of their points: whatever is ruled out so is not authentic to `authenticate` either."""

from __future__ import annotations

import numpy as np
import pytest

import meshmark as mm
from claims.authentication import forging
from claims.authentication.forging import Forger
from claims.authentication.subjects import KEY, Subject
from claims.authentication.vouching import Vouching
from meshmark.authentication.checks.checks import check
from meshmark.authentication.examination import examine
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.counting import some
from tests.shapes import pebble


@pytest.fixture(scope="module")
def forger() -> Forger:
    def other() -> Mesh:
        points, faces = pebble(64)
        longer = Mesh(points * [1.0, 1.0, 1.4], faces)
        return mm.embed(longer, KEY, id=9, layers="authentication", payload="none").mesh

    return Forger(Subject("pebble", Mesh(*pebble(64)), other))


KINDS = (
    "part edited",
    "part edited, its marks put at random places",
    "part edited, marked with another key",
    "part edited, rings replayed from another place",
    "part edited, rings replayed from another model",
    "a ring replayed from another place",
    "a ring replayed from another model",
    "brush stroke over two rings",
)
LONE = ("mark moved to a random place", "ring point moved, marks around at random places")


def test_these_are_the_kinds(forger):
    assert (tuple(forger.parts), tuple(forger.lone)) == (KINDS, LONE)


def authentic(forger: Forger, points: np.ndarray) -> bool:
    """Return what `authenticate` says, without its map, which takes most of its time."""
    found = examine(forger.mesh.with_vertices(points[forger.surface.point_of_vertex]), KEY)
    return found.marked and not found.altered.any() and not found.points_missing


@pytest.mark.parametrize("kind", [*KINDS, *LONE])
def test_what_is_ruled_out_is_not_authentic_and_every_try_changes_something(forger, kind):
    """Also of tries made so faint, down to shares of a float's last place, that some do pass."""
    rng = np.random.default_rng(len(kind))
    points = forger.surface.points
    change = (forger.parts | forger.lone)[kind]
    changed = points.copy()
    while not change(changed, rng):
        changed = points.copy()
    assert (changed != points).any()
    tries = points + np.array([1.0, 0.03, 0.001])[:, None, None] * (changed - points)
    tries = tries.astype(np.float32).astype(float)
    found = np.array([authentic(forger, each) for each in tries])
    assert not (found & ~forger.vouching.may_pass(tries, rng)).any()
    assert not found[0]


def test_what_moves_nothing_or_less_than_a_float_may_pass_and_does(forger):
    points = forger.surface.points
    near = points.copy()
    near[::7] = np.nextafter(near[::7].astype(np.float32), np.float32(np.inf)).astype(float)
    tries = np.stack([points, near])
    assert forger.vouching.may_pass(tries, np.random.default_rng(1)).all()
    assert all(forger.authentic(each) and authentic(forger, each) for each in some(tries))


def test_a_try_that_passes_is_counted(forger):
    def harmless(points: np.ndarray, rng: np.random.Generator) -> bool:
        points[rng.integers(len(points))] += 1e-9
        return True

    assert forger.accepted(harmless, 3, np.random.default_rng(1)) == 3


def test_a_wrong_ruling_does_not_go_by(forger, monkeypatch):
    monkeypatch.setattr(forger.vouching, "may_pass", lambda tries, rng: np.zeros(len(tries), bool))
    with pytest.raises(AssertionError, match="ruled out"):
        forger.accepted(lambda points, rng: True, 1, np.random.default_rng(1))


def test_rows_say_how_many_of_how_many_tries(forger, monkeypatch):
    monkeypatch.setattr(forging, "Forger", lambda subject: forger)
    monkeypatch.setattr(Forger, "accepted", lambda self, change, count, rng: count // 2)
    rows = list(forging.measure(Subject("pebble", forger.mesh), 20))
    assert sum(row.trials for row in rows if row.figure == "forged parts accepted") == 20
    assert sum(row.trials for row in rows if row.figure == "lone marks guessed, accepted") == 20
    assert {row.detail for row in rows} == {*KINDS, *LONE}
    assert all(row.value == (row.trials // 2) / row.trials for row in some(rows))


def test_marks_that_do_not_tell_the_id_are_read_with_that_of_the_ownership_layer():
    small = mm.embed(Mesh(*pebble(32)), KEY, id=9, layers="both", payload=b"few").mesh
    surface = weld(small)
    assert check(surface, KEY).nonce is None, "the marks tell the id: choose another one"
    vouching = Vouching(small, KEY)
    assert (vouching.held == check(surface, KEY, 9).passed).all()
    assert vouching.may_pass(surface.points[None], np.random.default_rng(1)).all()
    far = surface.points + 0.1 * np.random.default_rng(2).normal(size=surface.points.shape)
    assert not vouching.may_pass(far[None], np.random.default_rng(1)).any()


def test_an_unmarked_model_is_refused():
    with pytest.raises(mm.InputError, match="no marks of authentication"):
        Vouching(Mesh(*pebble(24)), KEY)
