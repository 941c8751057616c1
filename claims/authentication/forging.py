"""Forgeries: tries by one who knows the whole method, has marked models of the key, but not the key."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import meshmark as mm
from claims.authentication.figures import Row
from claims.authentication.places import around, directions
from claims.authentication.replay import Replay
from claims.authentication.subjects import KEY, Subject
from claims.authentication.vouching import Vouching
from meshmark.authentication.checks.checks import check
from meshmark.authentication.marks.plan import mark, plan
from meshmark.authentication.marks.precision import precision_of
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray

__all__ = ["LONE_TRIES", "TRIES", "Forger", "Try", "measure"]

TRIES = 10_000
"""Of each model, over all kinds of forged parts."""
LONE_TRIES = 2_000
"""Of each model, with a lone mark."""
# Shares of the points that a forged part has.
SHARES = (0.005, 0.02, 0.05)
# Tries of each kind that `authenticate` judges, whatever was said before.
AUDITED = 2
# Positions that are held at once.
_AT_ONCE = 1_000_000
_FORGERS_KEY = mm.Key(bytes(range(1, 33)))

Try = Callable[[FloatArray, np.random.Generator], bool]
"""Changes points (p, 3) in place; False where the place drawn does not suit."""


def measure(subject: Subject, draws: int | None) -> Iterator[Row]:
    """Yield how many of a number of tries of each kind are accepted; those with a lone mark apart."""
    forger = Forger(subject)
    tries, lone = draws or TRIES, min(draws or TRIES, LONE_TRIES)
    for figure, kinds, count in (
        ("forged parts accepted", forger.parts, tries),
        ("lone marks guessed, accepted", forger.lone, lone),
    ):
        for number, (kind, change) in enumerate(kinds.items()):
            share = count // len(kinds) + (number < count % len(kinds))
            accepted = forger.accepted(change, share, subject.rng(kind))
            if share:
                yield Row(figure, subject.name, kind, accepted / share, share)


class Forger:
    """A marked model as it is saved, and what can be tried with it."""

    def __init__(self, subject: Subject) -> None:
        mesh = subject.marked.mesh
        self.mesh = mm.Mesh(_single(mesh.vertices), mesh.faces)
        self.vouching = Vouching(self.mesh, KEY)
        surface = self.surface = self.vouching.surface
        self.size = float(np.linalg.norm(np.ptp(surface.points, axis=0)))
        self.step = self.vouching.typical_step
        self.graph: csr_array = self.vouching.near
        self.marks = self.vouching.held
        self.tree = cKDTree(surface.points)
        planned = plan(surface, _FORGERS_KEY, precision_of(self.mesh))
        again = mark(planned, _FORGERS_KEY, subject.marked.id, _no_symbols)
        self.marked_again = again.points
        other = weld(subject.donor())
        here = Replay(surface, surface, self.marks)
        there = Replay(surface, other, check(other, KEY).passed)
        self.parts: dict[str, Try] = {
            "part edited": self._edited,
            "part edited, its marks put at random places": self._guessed,
            "part edited, marked with another key": self._marked_again,
            "part edited, rings replayed from another place": partial(self._replayed, here),
            "part edited, rings replayed from another model": partial(self._replayed, there),
            "a ring replayed from another place": partial(self._ring, here),
            "a ring replayed from another model": partial(self._ring, there),
            "brush stroke over two rings": self._stroke,
        }
        self.lone: dict[str, Try] = {
            "mark moved to a random place": self._lone_mark,
            "ring point moved, marks around at random places": self._lone_point,
        }

    def accepted(self, change: Try, count: int, rng: np.random.Generator) -> int:
        """Return how many of these tries `authenticate` calls authentic."""
        points, at_once = self.surface.points, max(_AT_ONCE // len(self.surface.points), 1)
        accepted = done = 0
        while done < count:
            tries = np.repeat(points[None], min(at_once, count - done), axis=0)
            for each in tries:
                while not change(each, rng):
                    each[:] = points
            tries = _single(tries)
            may_pass = self.vouching.may_pass(tries, rng)
            audited = np.arange(done, done + len(tries)) < AUDITED
            for number in np.flatnonzero(may_pass | audited):
                passed = self.authentic(tries[number])
                if passed and not may_pass[number]:
                    raise AssertionError("a try that `authenticate` accepts was ruled out before")
                accepted += passed
            done += len(tries)
        return accepted

    def authentic(self, points: FloatArray) -> bool:
        """Return whether the model with these points (p, 3) is authentic."""
        moved = self.mesh.with_vertices(points[self.surface.point_of_vertex])
        return mm.authenticate(moved, KEY).verdict == "authentic"

    def _part(self, rng: np.random.Generator) -> tuple[IntArray, FloatArray, float]:
        """Return the points of a random part, weights that fall from 1 in its middle to 0, and its radius."""
        points = self.surface.points
        middle = points[rng.integers(len(points))]
        count = max(round(rng.choice(SHARES) * len(points)), 2)
        distance, part = (np.asarray(found) for found in self.tree.query(middle, count))
        radius = 1.05 * float(distance[-1])
        return part.astype(np.int64), (1.0 - (distance / radius) ** 2) ** 2, radius

    def _edited(self, points: FloatArray, rng: np.random.Generator) -> bool:
        self._edit(points, rng)
        return True

    def _edit(self, points: FloatArray, rng: np.random.Generator, rigid: bool = False) -> IntArray:
        """Push, roughen, move, turn or scale a part by 1 to 30 % of its radius; return its points."""
        part, weight, radius = self._part(rng)
        much = np.exp(rng.uniform(np.log(0.01), np.log(0.3)))
        middle, kind = points[part].mean(axis=0), rng.integers(2 if rigid else 0, 5)
        local = points[part] - middle
        if kind == 0:
            local += much * radius * weight[:, None] * directions(1, rng)
        elif kind == 1:
            local += 0.1 * much * radius * rng.normal(size=local.shape)
        elif kind == 2:
            local += much * radius * directions(1, rng)
        elif kind == 3:
            local = local @ Rotation.from_rotvec(much * directions(1, rng)[0]).as_matrix()
        else:
            local *= 1.0 + rng.choice([-1.0, 1.0]) * much
        points[part] = middle + local
        return part

    def _guessed(self, points: FloatArray, rng: np.random.Generator) -> bool:
        part = self._edit(points, rng)
        marks = part[self.marks[part]]
        points[marks] += rng.uniform(-4.0, 4.0, (len(marks), 3)) * self.step
        return True

    def _marked_again(self, points: FloatArray, rng: np.random.Generator) -> bool:
        """Mark the part with a key of one's own, which the ways of a part moved as one leave whole."""
        before = points.copy()
        points[:] = self.marked_again
        part = self._edit(points, rng, rigid=True)
        before[part] = points[part]
        points[:] = before
        return True

    def _replayed(self, replay: Replay, points: FloatArray, rng: np.random.Generator) -> bool:
        part = self._edit(points, rng)
        done = [replay(points, place, rng) for place in part[self.marks[part]].tolist()]
        return any(done)

    def _ring(self, replay: Replay, points: FloatArray, rng: np.random.Generator) -> bool:
        return replay(points, self._drawn(self.vouching.sure, rng), rng)

    def _stroke(self, points: FloatArray, rng: np.random.Generator) -> bool:
        """Push a point and those within two edges, these less, by one to thirty steps."""
        way = np.exp(rng.uniform(0.0, np.log(30.0))) * self.step * directions(1, rng)[0]
        place = self._drawn(self.vouching.sure, rng)
        for steps, share in ((2, 0.25), (1, 0.25), (0, 0.5)):
            points[around(self.graph, place, steps)] += share * way
        return True

    def _lone_mark(self, points: FloatArray, rng: np.random.Generator) -> bool:
        """Move one mark by three to ten steps, in the hope that its place there says a word that holds."""
        place = self._drawn(self.marks & self.vouching.sure, rng)
        points[place] += rng.uniform(3.0, 10.0) * self.step * directions(1, rng)[0]
        return True

    def _lone_point(self, points: FloatArray, rng: np.random.Generator) -> bool:
        """Move a point of rings by three to ten steps, and try new places for all marks whose rings it is in."""
        place = self._drawn(~self.marks & self.vouching.sure, rng)
        near = around(self.graph, place, 1)
        marks = near[self.marks[near]]
        points[place] += rng.uniform(3.0, 10.0) * self.step * directions(1, rng)[0]
        points[marks] += rng.uniform(-4.0, 4.0, (len(marks), 3)) * self.step
        return len(marks) > 0

    @staticmethod
    def _drawn(allowed: NDArray[np.bool_], rng: np.random.Generator) -> int:
        return int(rng.choice(np.flatnonzero(allowed)))


def _single(positions: FloatArray) -> FloatArray:
    return positions.astype(np.float32).astype(np.float64)


def _no_symbols(index: NDArray[np.uint32]) -> NDArray[np.uint16]:
    return np.zeros(len(index), np.uint16)
