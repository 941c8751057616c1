"""The id in the points of a surface: the best choice within what may be moved and seen, read back blind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice, product

from meshmark.errors import CapacityError
from meshmark.geometry.surface_of import surface_of_moved
from meshmark.mesh import Mesh
from meshmark.ownership.embedding_task import EmbeddingTask, Owned
from meshmark.ownership.extraction import find
from meshmark.ownership.ownership_mark import OwnershipMark
from meshmark.ownership.points.parameters import (
    DISTINCT_BITS,
    LARGEST,
    MODES,
    MOST_POINTS,
    SHARES,
    SIDE,
    STEPS,
)
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_shaping import Choice, PointShaping
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import TrialCounter
from meshmark.ownership.vertex_displacement import displacement_rms

__all__ = ["embed_in_points"]

# Choices that are tried.
TRIES = 16
# The next step after one that did not do is smaller by this factor.
SMALLER = 0.75
# A mark bears noise in proportion to its step, and about to this power of the number of code bits beyond those
# needed.
NEEDED, REDUNDANCY = 72, 0.4
# What that is worth in each mode: the less of the surface leaves its planes the better.
WORTH = (1.0, 0.9, 0.75, 0.6)


def embed_in_points(task: EmbeddingTask) -> Owned:
    """Return the first mark that is read back, of a few choices, from the one that bears most noise down.

    Raises `CapacityError` that says what the points lack.
    """
    used = int(task.surface.used.sum())
    if len(task.surface.points) > MOST_POINTS:
        raise CapacityError(
            f"its {used:,} points are too many for points to carry it, {MOST_POINTS:,} at most"
        )
    lattice = PointLattice.keyed(task.key, task.label)
    budget = task.budget / task.diagonal
    shaping = PointShaping(task.surface, lattice, task.bits, largest=LARGEST[task.strength], budget=budget)
    for choice in islice(_choices(shaping, budget), TRIES):
        points = shaping.shaped(choice)
        if points is None or task.seen.of(points).share > task.share:
            continue
        marked = task.moved(points)
        if displacement_rms(task.mesh, marked) > task.budget:
            continue
        carriers = _read_back(task, marked)
        if carriers:
            step = choice.step / SIDE
            mark = OwnershipMark(carriers=carriers, label=task.label, spacing=SIDE, step=step, at_points=True)
            return Owned(mesh=marked, mark=mark)
    most = max(
        shaping.distinct_bits(Choice(step=float(STEPS[0]), mode=mode, share=1.0))
        for mode in range(len(MODES))
    )
    if most < DISTINCT_BITS:
        raise CapacityError(f"its {used} points carry {most} bits of the code, {DISTINCT_BITS} are needed")
    raise CapacityError("its points cannot be moved far enough to carry it without being seen")


def _choices(shaping: PointShaping, budget: float) -> Iterator[Choice]:
    """Yield choices within an RMS budget (over the diagonal), the best first.

    Of what a failed choice would be followed by, nearly the same is left out.
    """
    fitting = []
    for step, mode, share in product(STEPS, range(len(MODES)), SHARES):
        choice = Choice(step=float(step), mode=mode, share=share)
        count = shaping.distinct_bits(choice)
        if count >= DISTINCT_BITS and shaping.rms(choice) <= budget:
            fitting.append((WORTH[mode] * step * (count - NEEDED) ** REDUNDANCY, choice))
    fitting.sort(key=lambda entry: -entry[0])
    left = [choice for _, choice in fitting]
    while left:
        first = left.pop(0)
        yield first
        left = [each for each in left if each.step <= SMALLER * first.step or each.mode != first.mode]


def _read_back(task: EmbeddingTask, marked: Mesh) -> int:
    """Return how many coordinates an extraction reads the id from, 0 where it does not."""
    search = Search(surface=surface_of_moved(marked, task.mesh), key=task.key, effort="plain")
    # The points alone fail sooner than everything would.
    if find(replace(search, spacings=())).id != task.identity:
        return 0
    found = find(replace(search, trials=TrialCounter()))
    return found.carriers if found.id == task.identity else 0
