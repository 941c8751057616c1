"""The id in the points of a surface: the best choice within what may be moved and seen, read back blind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.message import ID_BITS
from meshmark.errors import CapacityError
from meshmark.geometry.plane_patches import PlanePatches
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
from meshmark.ownership.points.targets import Word
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
# Share of what a choice may be worth at most, below which the best that keeps planes is compared with those that
# may bend them.
WEAK = 0.25
# How often parts where marks are seen are left alone, and of how many choices they are.
ALONE, LOOKS = 2, 3
# Share of the coordinates at most where others are to carry a fingerprint.
BESIDE_FINGERPRINT = 0.25
# Of models with at most so many points, marks of fewer bits than 64 are chosen by after how many of these noises
# they are read, about that of a grid of 12 bits, over the diagonal; of those that are read without, so many.
CLOSELY, NOISES, NOISE, COMPARED = 300, 4, 5e-5, 3


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
    tried: list[_Tried] = []
    told = 0.0
    for planes, still in _rounds(task, lattice):
        shaping = _shaping(task, lattice, planes, still)
        tries = list(_tries(task, shaping, lattice))
        if not tries:
            break  # no choice has room, however planes bend
        hoped = max(worth for worth, _ in tries)
        tried += [made for _, made in tries if made is not None]
        told = max([told, *(each.told for each in tried)])
        if planes is None or max((each.worth for each in tried), default=0.0) >= WEAK * hoped:
            best = _best_read(task, tried)
            if best is not None:
                return best
            tried = []  # none of them is read
    most = max(
        shaping.expected(Choice(step=float(STEPS[0]), mode=mode, share=1.0))[0] for mode in range(len(MODES))
    )
    raise CapacityError(_lacking(used, most, told, DISTINCT_BITS[task.bits]))


def _rounds(
    task: EmbeddingTask, lattice: PointLattice
) -> Iterator[tuple[PlanePatches | None, NDArray[np.bool_] | None]]:
    """Yield the planes that are kept and the points (p,) that stay where they are, until a mark is read."""
    # Planes that are kept leave less room for coordinates to be set: where it is too little, they may bend.
    if task.has_planes:
        yield task.planes, None
    yield None, None
    # Where the mark is seen on a part of the surface whatever is chosen, that part is left alone.
    still = np.zeros(len(task.surface.points), bool)
    for _ in range(ALONE):
        shaping = _shaping(task, lattice, None, still)
        for _, choice in islice(_choices(shaping, task), LOOKS):
            points = shaping.shaped(choice)
            if points is not None:
                still |= task.seen.seen(points)
        yield None, still


def _shaping(
    task: EmbeddingTask, lattice: PointLattice, planes: PlanePatches | None, still: NDArray[np.bool_] | None
) -> PointShaping:
    return PointShaping(
        task.surface,
        lattice,
        Word(task.word),
        largest=LARGEST[task.strength],
        budget=task.rms,
        still=still,
        planes=planes,
    )


class _Tried(NamedTuple):
    """A choice that could be made: its worth, its step, how many bits it tells, and the marked mesh."""

    worth: float
    step: float
    told: float
    mesh: Mesh


def _tries(
    task: EmbeddingTask, shaping: PointShaping, lattice: PointLattice
) -> Iterator[tuple[float, _Tried | None]]:
    """Yield what a few choices are worth at most, and what became of them, None where they cannot be made."""
    best: float | None = None
    for most, choice in islice(_choices(shaping, task), TRIES):
        if best is not None and most <= best:
            break  # the rest is worth less even where everything can be set
        mesh = _made(task, shaping, choice)
        if mesh is None:
            yield most, None
            continue
        told = _told(task, mesh, lattice, choice)
        worth = _worth(choice, told, task.bits) * (1.0 if task.keeps_planes(mesh) else DENTED)
        best = worth if best is None else max(best, worth)
        yield most, _Tried(worth, choice.step, told, mesh)


def _best_read(task: EmbeddingTask, tried: list[_Tried]) -> Owned | None:
    """Return the mark of the choice of most worth that is read back, and of few bits of those that bears most."""
    best: tuple[int, Owned] | None = None
    compared = 0
    for each in sorted(tried, key=lambda each: -each.worth):
        carriers = _read_back(task, each.mesh) if each.worth > 0.0 else 0
        if carriers:
            mark = OwnershipMark(
                carriers=carriers,
                frame=task.surface.frame,
                label=task.label,
                spacing=SIDE,
                step=each.step / SIDE,
                at_points=True,
                bits=task.bits,
            )
            borne = _borne(task, each.mesh)
            compared += 1
            if best is None or borne > best[0]:
                best = borne, Owned(mesh=each.mesh, mark=mark)
            if borne == NOISES or compared == COMPARED:
                break
    return None if best is None else best[1]


def _lacking(used: int, most: int, told: float, needed: int) -> str:
    """Return what so many points lack; most: bits of the code that they carry, told: how many of them were set."""
    carry = f"its {used} points carry {most} bits of the code"
    if most < needed:
        return f"{carry}, {needed} are needed"
    if told < needed:
        return f"{carry}, of which {told:.0f} can be set without being seen, {needed} are needed"
    return f"{carry}, of which {told:.0f} can be set without being seen, but not so that they are read back"


def _choices(shaping: PointShaping, task: EmbeddingTask) -> Iterator[tuple[float, Choice]]:
    """Yield choices within the RMS budget, and what they are worth at most, the best first.

    Of what a choice is followed by, nearly the same is left out.
    """
    left = []
    most = BESIDE_FINGERPRINT if task.may_have_fingerprint else 1.0
    for step, mode, share in product(STEPS, range(len(MODES)), [each for each in SHARES if each <= most]):
        choice = Choice(step=float(step), mode=mode, share=share)
        count, rms = shaping.expected(choice)
        if count >= DISTINCT_BITS[task.bits] and rms <= task.rms:
            left.append((_worth(choice, count, task.bits), choice))
    left.sort(key=lambda entry: -entry[0])
    while left:
        first = left.pop(0)
        yield first
        _, done = first
        left = [entry for entry in left if entry[1].step <= SMALLER * done.step or entry[1].mode != done.mode]


def _worth(choice: Choice, carried: float, bits: int) -> float:
    """Return how much noise a mark bears of an id of `bits` in this number of code bits.

    In units that only compare choices.
    """
    return WORTH[choice.mode] * noise_borne(choice.step, carried, bits)


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


def _borne(task: EmbeddingTask, marked: Mesh) -> int:
    """Return after how many of `NOISES` noises, until the first after which it is not, the id is read.

    With few carriers it depends on single ones what a mark bears; with 64 bits its worth says that well enough.
    """
    surface = surface_of_moved(marked, task.mesh)
    if task.bits == ID_BITS or len(surface.points) > CLOSELY:
        return NOISES
    rng = np.random.default_rng(0)  # the same noises every time
    for number in range(NOISES):
        noise = NOISE * task.diagonal * rng.normal(size=surface.points.shape)
        search = Search(surface=surface.moved(surface.points + noise), key=task.key, effort="plain")
        if find(search).id != task.identity:
            return number
    return NOISES


def _read_back(task: EmbeddingTask, marked: Mesh) -> int:
    """Return how many coordinates an extraction reads the id from, 0 where it does not."""
    search = Search(surface=surface_of_moved(marked, task.mesh), key=task.key, effort="plain")
    # The points alone fail sooner than everything would.
    if find(replace(search, spacings=())).id != task.identity:
        return 0
    found = find(replace(search, trials=TrialCounter()))
    return found.carriers if found.id == task.identity else 0
