"""Bars 3 and 9: single points moved, and forgeries of a ring, many far from each other in each check."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

import meshmark as mm
from benchmarks.authentication.figures import Row
from benchmarks.authentication.places import around, far_apart
from benchmarks.authentication.replay import Replay
from benchmarks.authentication.subjects import KEY, Subject, donor
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray
from meshmark.schemes.ncdg_lv.authentication.checks import check
from meshmark.schemes.ncdg_lv.authentication.localisation import altered_points

__all__ = ["TRIES", "measure_forgeries", "measure_moves"]

TRIES = 10_000
STEP = 3.3 * 1.42
"""Step of a ring of median spread, rounded up to the next power of sqrt 2, over that of a ring of spread 1."""

Change = Callable[[FloatArray, int, np.random.Generator], bool]


class _Bench:
    """A marked model, and what becomes of it when it is changed in many places."""

    def __init__(self, subject: Subject) -> None:
        self.mesh = subject.marked.mesh
        self.surface = weld(self.mesh)
        count = len(self.surface.points)
        self.graph = csr_array(adjacency(unique_edges(self.surface.faces), count))
        checks = check(self.surface, KEY)
        self.allowed = checks.eligible & checks.verified
        self.marks = checks.passed
        self.step = STEP * checks.step

    def trials(
        self, change: Change, tries: int, rng: np.random.Generator, reach: int
    ) -> tuple[list[bool], int]:
        """Return of so many changes whether each was seen within `reach` edges, as far as it shows, and how many
        that were not seen there are authentic alone.
        """
        seen: list[bool] = []
        accepted = 0
        for _ in range(tries):
            if len(seen) >= tries:
                break
            points = self.surface.points.copy()
            drawn = far_apart(self.graph, self.allowed, 2 * reach, rng)[: tries - len(seen)]
            places = [place for place in drawn.tolist() if change(points, place, rng)]
            found = self._altered(points)
            for place in places:
                seen.append(bool(found[around(self.graph, place, reach)].any()))
                if not seen[-1]:
                    accepted += self._accepted_alone(points, place, reach)
        return seen, accepted

    def _altered(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return (p,): what is altered in the model with these points, saved in single precision."""
        surface = weld(self._saved(points))
        found = altered_points(surface, check(surface, KEY))
        altered = np.zeros(len(points), bool)
        altered[self.surface.point_of_vertex] = found[surface.point_of_vertex]
        return altered

    def _saved(self, points: FloatArray) -> mm.Mesh:
        single = points.astype(np.float32).astype(np.float64)
        return mm.Mesh(single[self.surface.point_of_vertex], self.mesh.faces)

    def _accepted_alone(self, points: FloatArray, place: int, reach: int) -> bool:
        alone = self.surface.points.copy()
        near = around(self.graph, place, reach)
        alone[near] = points[near]
        return mm.authenticate(self._saved(alone), KEY).verdict == "authentic"


def measure_moves(subject: Subject, draws: int | None) -> Iterator[Row]:
    """Yield how often a point that moves by one to two steps is seen, and ten of them."""
    bench = _Bench(subject)
    seen, _ = bench.trials(partial(_moved, bench), draws or TRIES, subject.rng("moves"), 2)
    tens = [any(seen[i : i + 10]) for i in range(0, len(seen) - 9, 10)]
    yield Row("one point moved by 1 to 2 steps, seen", subject.name, "", float(np.mean(seen)), len(seen))
    if tens:
        yield Row("ten points so moved, seen", subject.name, "", float(np.mean(tens)), len(tens))


def measure_forgeries(subject: Subject, draws: int | None) -> Iterator[Row]:
    """Yield how many forgeries of each kind are accepted."""
    bench = _Bench(subject)
    other = weld(donor())
    kinds: dict[str, tuple[Change, int]] = {
        "brush stroke": (partial(_stroke, bench), 4),
        "ring replayed from another place": (Replay(bench.surface, bench.surface, bench.marks), 3),
        "ring replayed from another model": (Replay(bench.surface, other, check(other, KEY).passed), 3),
        "ring point moved, marks around guessed": (partial(_guessed, bench), 3),
        "mark moved, its new place guessed": (partial(_mark_guessed, bench), 3),
    }
    for kind, (change, reach) in kinds.items():
        seen, accepted = bench.trials(change, (draws or TRIES) // len(kinds), subject.rng(kind), reach)
        if seen:
            yield Row("forged parts accepted", subject.name, kind, accepted / len(seen), len(seen))


def _moved(bench: _Bench, points: FloatArray, place: int, rng: np.random.Generator) -> bool:
    points[place] += rng.uniform(1.0, 2.0) * bench.step * _directions(1, rng)[0]
    return True


def _stroke(bench: _Bench, points: FloatArray, place: int, rng: np.random.Generator) -> bool:
    """Push a point and those within two edges, these less, by one to thirty steps."""
    way = np.exp(rng.uniform(0.0, np.log(30.0))) * bench.step * _directions(1, rng)[0]
    for steps, share in ((2, 0.25), (1, 0.25), (0, 0.5)):
        points[around(bench.graph, place, steps)] += share * way
    return True


def _guessed(bench: _Bench, points: FloatArray, place: int, rng: np.random.Generator) -> bool:
    """Move a point of rings by three to ten steps, and try new places for all marks whose rings it is in."""
    near: IntArray = around(bench.graph, place, 1)
    marks = near[bench.marks[near]]
    if bench.marks[place] or not len(marks):
        return False
    points[place] += rng.uniform(3.0, 10.0) * bench.step * _directions(1, rng)[0]
    points[marks] += rng.uniform(-4.0, 4.0, (len(marks), 3)) * bench.step
    return True


def _mark_guessed(bench: _Bench, points: FloatArray, place: int, rng: np.random.Generator) -> bool:
    """Move one mark by three to ten steps, in the hope that its place there says a word that holds."""
    if bench.marks[place]:
        points[place] += rng.uniform(3.0, 10.0) * bench.step * _directions(1, rng)[0]
    return bool(bench.marks[place])


def _directions(count: int, rng: np.random.Generator) -> FloatArray:
    ways = rng.normal(size=(count, 3))
    return np.asarray(ways / np.linalg.norm(ways, axis=1)[:, None])
