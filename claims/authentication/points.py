"""Moves: single points moved, many far from each other in each check."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

import meshmark as mm
from claims.authentication.figures import Row
from claims.authentication.places import around, directions, far_apart
from claims.authentication.subjects import KEY, Subject
from meshmark.authentication.checks.altered_points import altered_points
from meshmark.authentication.checks.checks import check
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray

__all__ = ["TRIES", "measure_moves"]

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

    def trials(self, change: Change, tries: int, rng: np.random.Generator, reach: int) -> list[bool]:
        """Return of a number of changes whether each was seen within `reach` edges, as far as it shows."""
        seen: list[bool] = []
        for _ in range(tries):
            if len(seen) >= tries:
                break
            points = self.surface.points.copy()
            drawn = far_apart(self.graph, self.allowed, 2 * reach, rng)[: tries - len(seen)]
            places = [place for place in drawn.tolist() if change(points, place, rng)]
            found = self._altered(points)
            seen += [bool(found[around(self.graph, place, reach)].any()) for place in places]
        return seen

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


def measure_moves(subject: Subject, draws: int | None) -> Iterator[Row]:
    """Yield how often a point that moves by one to two steps is seen, and ten of them."""
    bench = _Bench(subject)
    seen = bench.trials(partial(_moved, bench), draws or TRIES, subject.rng("moves"), 2)
    tens = [any(seen[i : i + 10]) for i in range(0, len(seen) - 9, 10)]
    yield Row("one point moved by 1 to 2 steps, seen", subject.name, "", float(np.mean(seen)), len(seen))
    if tens:
        yield Row("ten points so moved, seen", subject.name, "", float(np.mean(tens)), len(tens))


def _moved(bench: _Bench, points: FloatArray, place: int, rng: np.random.Generator) -> bool:
    points[place] += rng.uniform(1.0, 2.0) * bench.step * directions(1, rng)[0]
    return True
