"""The id in the points of a surface: the best choice within what may be moved and seen, read back blind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice, product

import numpy as np

from meshmark.errors import CapacityError
from meshmark.geometry.surface_of import surface_of_moved
from meshmark.mesh import Mesh
from meshmark.ownership.embedding_task import EmbeddingTask, Owned
from meshmark.ownership.extraction import find
from meshmark.ownership.ownership_mark import OwnershipMark, noise_borne
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.parameters import (
    DISTINCT_BITS,
    LARGEST,
    MODES,
    MOST_POINTS,
    SHARES,
    SIDE,
    STEPS,
)
from meshmark.ownership.points.point_choice import Choice
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_reading import Framed
from meshmark.ownership.points.point_shaping import PointShaping
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import TrialCounter
from meshmark.ownership.vertex_displacement import displacement_rms

__all__ = ["embed_in_points"]

# Choices that are tried.
TRIES = 12
# The next step after one that did not do is smaller by this factor.
SMALLER = 0.75
# What that is worth in each mode: the less of the surface leaves its planes the better. And where plane parts leave
# them further than they should.
WORTH = (1.0, 0.9, 0.75, 0.6)
DENTED = 0.5


def embed_in_points(task: EmbeddingTask) -> Owned:
    """Return the mark that bears most noise, of a few choices, and is read back.

    Raises `CapacityError` that says what the points lack.
    """
    used = int(task.surface.used.sum())
    if len(task.surface.points) > MOST_POINTS:
        raise CapacityError(
            f"its {used:,} points are too many for points to carry it, {MOST_POINTS:,} at most"
        )
    lattice = PointLattice.keyed(task.key, task.label)
    shaping = PointShaping(task.surface, lattice, task.bits, largest=LARGEST[task.strength], budget=task.rms)
    tried: list[tuple[float, float, Mesh]] = []
    for worth, choice in islice(_choices(shaping, task.rms), TRIES):
        if tried and worth <= max(worth for worth, _, _ in tried):
            break  # the rest is worth less even where everything can be set
        made = _made(task, shaping, choice)
        if made is not None:
            worth = _worth(choice, _told(task, made, lattice, choice))
            tried.append((worth if task.keeps_planes(made) else DENTED * worth, choice.step, made))
    for worth, step, marked in sorted(tried, key=lambda entry: -entry[0]):
        carriers = _read_back(task, marked) if worth > 0.0 else 0
        if carriers:
            step /= SIDE
            mark = OwnershipMark(carriers=carriers, label=task.label, spacing=SIDE, step=step, at_points=True)
            return Owned(mesh=marked, mark=mark)
    most = max(
        shaping.expected(Choice(step=float(STEPS[0]), mode=mode, share=1.0))[0] for mode in range(len(MODES))
    )
    if most < DISTINCT_BITS:
        raise CapacityError(f"its {used} points carry {most} bits of the code, {DISTINCT_BITS} are needed")
    raise CapacityError("its points cannot be moved far enough to carry it without being seen")


def _choices(shaping: PointShaping, budget: float) -> Iterator[tuple[float, Choice]]:
    """Yield choices within an RMS budget (over the diagonal), and what they are worth at most, the best first.

    Of what a choice is followed by, nearly the same is left out.
    """
    left = []
    for step, mode, share in product(STEPS, range(len(MODES)), SHARES):
        choice = Choice(step=float(step), mode=mode, share=share)
        count, rms = shaping.expected(choice)
        if count >= DISTINCT_BITS and rms <= budget:
            left.append((_worth(choice, count), choice))
    left.sort(key=lambda entry: -entry[0])
    while left:
        first = left.pop(0)
        yield first
        _, done = first
        left = [entry for entry in left if entry[1].step <= SMALLER * done.step or entry[1].mode != done.mode]


def _worth(choice: Choice, bits: float) -> float:
    """Return how much noise a mark of `bits` code bits bears, in units that only compare choices."""
    return WORTH[choice.mode] * noise_borne(choice.step, bits)


def _made(task: EmbeddingTask, shaping: PointShaping, choice: Choice) -> Mesh | None:
    """Return the mesh marked as chosen, None where it would be seen, or moves too much."""
    points = shaping.shaped(choice)
    if points is None or task.seen.of(points).share > task.share:
        return None
    marked = task.moved(points)
    return None if displacement_rms(task.mesh, marked) > task.budget else marked


def _told(task: EmbeddingTask, marked: Mesh, lattice: PointLattice, choice: Choice) -> float:
    """Return how many bits a mark tells as it is read; points that could not be set say what chance has."""
    # In the frame that was held: that of the marked surface may be another turn of it.
    surface, frame = surface_of_moved(marked, task.mesh), task.surface.frame
    framed = Framed.of(surface, Carried.of(surface, frame), frame, lattice)
    reading = framed.reading(choice, 1.0)
    if not len(reading.phase):
        return 0.0
    wrong = 1.0 / (1.0 + np.exp(np.abs(reading.ratios())))
    entropy = -(wrong * np.log2(wrong) + (1.0 - wrong) * np.log2(1.0 - wrong))
    return len(np.unique(reading.keys.code_index)) * float(1.0 - entropy.mean())


def _read_back(task: EmbeddingTask, marked: Mesh) -> int:
    """Return how many coordinates an extraction reads the id from, 0 where it does not."""
    search = Search(surface=surface_of_moved(marked, task.mesh), key=task.key, effort="plain")
    # The points alone fail sooner than everything would.
    if find(replace(search, spacings=())).id != task.identity:
        return 0
    found = find(replace(search, trials=TrialCounter()))
    return found.carriers if found.id == task.identity else 0
