"""The id once more in each large part of a marked assembly, in its points, so that a part taken out still tells it.

The mark of the whole stays as it is: points slide along the surface, which its cells do not see. Where the whole is
marked at points, those that carry its bits stay where they are, and the others carry those of the part; where that
is too little, all do, by steps that are small beside those of the whole.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, product
from math import inf, sqrt

import numpy as np

from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.geometry.frame import Frame
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray
from meshmark.ownership.assembly_parts import AssemblyPart, parts_held_apart
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carrying_points import carrying_points
from meshmark.ownership.decoding import Listed, decoded
from meshmark.ownership.embedding_task import EmbeddingTask, Owned
from meshmark.ownership.extraction import find
from meshmark.ownership.mark_left import MarkLeft, points_of
from meshmark.ownership.ownership_mark import noise_borne
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.parameters import DISTINCT_BITS, LARGEST, SHARES, STEPS
from meshmark.ownership.points.point_choice import Choice
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_reading import Framed
from meshmark.ownership.points.point_shaping import PointShaping
from meshmark.ownership.points.targets import Word
from meshmark.ownership.search.search import Search
from meshmark.ownership.vertex_displacement import displacement_rms

__all__ = ["SURE", "embed_in_parts", "is_read_in_part", "with_parts_apart"]

SURE = -12.0
"""A part's mark counts where its bound is below 10^this: as a part it pays for further trials."""
# Share of the budget that the mark of a part may move its points by, RMS, and of the largest displacement.
PART_BUDGET, PART_LARGEST = 0.25, 0.3
# Of the budget that what the stretch of round parts is measured by; it takes less than a third of that.
STRETCH = 0.6
# Choices that are tried for each part, and of the modes of `points.parameters.MODES` how much each is worth.
TRIES, WORTH = 2, (1.0, 0.9, 0.75)
# The next one has another mode, or a step smaller by this factor.
SMALLER = 0.75
# A layer on top moves this share of the points by this much along each axis, over the diagonal of the whole: the
# first choice is taken that bears it, else the first that is read. What share of its code bits is counted on.
SHAKEN, SHAKE, COUNTED_ON = 0.3, 1.4e-4, 0.6
# It bears that where the bound is below 10^this then, with the frame known: the frame takes its share.
BEARS = -40.0
# Code bits that a part has at least beyond those that an id takes.
MORE_BITS = 12
# How much of the lock of a mark at points of the whole the marks of the parts may cost by their steps, about, tried
# in turn.
COSTS = (0.06, 0.02)
# A motion along a carrying coordinate by a step as large as its own costs this times the lock.
COST_OF_STEP = 5.0
# Points that a part moved by less than this, over the diagonal, went along for the sake of its frame.
STAYED = 2e-5


def with_parts_apart(task: EmbeddingTask, parts: Sequence[AssemblyPart]) -> EmbeddingTask:
    """Return the task with round parts stretched, so that marks on their own frames are found again."""
    surface = task.surface
    points = parts_held_apart(surface.points, tuple(parts), STRETCH * task.budget)
    if points is surface.points:
        return task
    mesh = task.moved(points)
    used = displacement_rms(task.mesh, mesh) / task.diagonal
    return replace(task, mesh=mesh, rms=sqrt(max(task.rms**2 - used**2, 0.0)))


def embed_in_parts(task: EmbeddingTask, owned: Owned, parts: Sequence[AssemblyPart]) -> Owned:
    """Return a marked mesh with the id in those of its parts that can carry it, where that costs the whole little.

    Parameters
    ----------
    task : EmbeddingTask
        Of the unmarked mesh.
    owned : Owned
        The mark of the whole.
    parts : sequence of AssemblyPart
        Of the surface of the unmarked mesh.
    """
    left = MarkLeft(task=task, owned=owned)
    for cost in COSTS if owned.mark.at_points else COSTS[:1]:
        made = _marked(task, owned, parts, cost)
        if made.mark.parts and left.enough_in(made):
            moved = np.linalg.norm(points_of(task, made.mesh) - points_of(task, owned.mesh), axis=1)
            return replace(made, held=moved > STAYED * task.diagonal)
    return owned


def _marked(task: EmbeddingTask, owned: Owned, parts: Sequence[AssemblyPart], cost: float) -> Owned:
    """Return the mesh with the id in as many parts as carry it."""
    points = points_of(task, owned.mesh)
    taken = carrying_points(task, owned)
    step = owned.mark.step * owned.mark.spacing * task.surface.frame.scale
    carrying = []
    for number, part in enumerate(parts):
        beside = replace(part, still=part.still | taken[part.rows])
        ways = [(beside, _Limits(step=inf, cost=cost))]
        if owned.mark.at_points:
            ways.append((part, _Limits(step=step, cost=cost)))
        own = _in_part(task, points, ways)
        if own is not None:
            points = points.copy()
            points[part.rows] = own
            carrying.append(number)
    return replace(owned, mesh=task.moved(points), mark=replace(owned.mark, parts=tuple(carrying)))


@dataclass(frozen=True, kw_only=True)
class _Limits:
    """What a part may cost the whole. step: of the mark of the whole, scene units; infinite where it is in cells.

    cost: share of the lock of the whole.
    """

    step: float
    cost: float

    def allow(self, choice: Choice, scale: float) -> bool:
        """Return whether a choice for a part of this canonical scale costs no more of the lock than it may."""
        return choice.share * min(1.0, COST_OF_STEP * (choice.step * scale / self.step) ** 2) <= self.cost


def _in_part(
    task: EmbeddingTask, points: FloatArray, ways: Sequence[tuple[AssemblyPart, _Limits]]
) -> FloatArray | None:
    """Return the marked points (k, 3) of a part of a surface with these points (p, 3), None where it cannot be.

    ways: the part with what must stay still, and what it may cost. The first that bears a layer on top is taken,
    else that which bears most.
    """
    made = [each for part, limits in ways for each in _made(task, points, part, limits)]
    for each in sorted(made, key=lambda each: max(each.bound, BEARS)):
        if is_read_in_part(each.surface, task.key, task.identity):
            return each.points
    return None


@dataclass(frozen=True, eq=False, kw_only=True)
class _Made:
    """A marked part. points: (k, 3); surface: as the file holds it.

    bound: log10 of that on a false positive with a layer on top, its frame known; 0 where the id is lost.
    """

    points: FloatArray
    surface: Surface
    bound: float


def _made(task: EmbeddingTask, points: FloatArray, part: AssemblyPart, limits: _Limits) -> Iterator[_Made]:
    """Yield a part marked by one choice after another, not yet read back."""
    before = part.surface(points)
    if before is None:
        return
    codec = Codec(task.key)
    lattice = PointLattice.keyed(task.key, Label.of_shape(before.invariants, task.key))
    shaping = PointShaping(
        before,
        lattice,
        Word(task.word),
        largest=PART_LARGEST * LARGEST[task.strength] * task.diagonal / before.diagonal,
        budget=0.0,  # what there is of round parts was stretched before the whole was marked
        still=part.still,
        holds_area=True,
    )
    for choice in islice(_choices(task, shaping, before, limits), TRIES):
        moved = shaping.shaped(choice)
        if moved is None:
            continue
        whole = points.copy()
        whole[part.rows] = moved
        surface = part.surface(points_of(task, task.moved(whole)))
        if surface is not None:
            framed = _framed(_shaken(surface, task.diagonal), before.frame, lattice)
            told = decoded(codec, framed.reading(choice, 1.0), Listed(ids=(), words=codec.words(())))
            bound = 0.0 if told is None or told.id != task.identity else told.log10_false_positive
            yield _Made(points=moved, surface=surface, bound=bound)


def _framed(surface: Surface, frame: Frame, lattice: PointLattice) -> Framed:
    return Framed.of(surface, Carried.of(surface, frame), frame, lattice)


def _shaken(surface: Surface, diagonal: float) -> Surface:
    """Return a surface about as a layer on top leaves it; diagonal: of the whole."""
    rng = np.random.default_rng(0)  # the same every time
    moves = rng.random(len(surface.points)) < SHAKEN
    shift = SHAKE * diagonal * rng.uniform(-1.0, 1.0, surface.points.shape)
    return surface.moved(surface.points + np.where(moves[:, None], shift, 0.0))


def _choices(
    task: EmbeddingTask, shaping: PointShaping, surface: Surface, limits: _Limits
) -> Iterator[Choice]:
    """Yield the choices for a part that bear most noise, of those that the whole allows."""
    found: list[tuple[tuple[float, float], Choice]] = []
    for step, mode, share in product(STEPS, range(len(WORTH)), SHARES):
        choice = Choice(step=float(step), mode=mode, share=share)
        if not limits.allow(choice, surface.frame.scale):
            continue
        count, rms = shaping.expected(choice)
        if (
            count >= DISTINCT_BITS[task.bits] + MORE_BITS
            and rms * surface.diagonal <= PART_BUDGET * task.budget
        ):
            borne = WORTH[mode] * noise_borne(choice.step, COUNTED_ON * count, task.bits)
            found.append(((borne, choice.step * sqrt(count)), choice))
    found.sort(key=lambda entry: entry[0], reverse=True)
    while found:
        _, done = found.pop(0)
        yield done
        found = [each for each in found if each[1].mode != done.mode or each[1].step <= SMALLER * done.step]


def is_read_in_part(surface: Surface, key: Key, identity: int) -> bool:
    """Return whether the id is surely read from the points of a part's surface."""
    found = find(Search(surface=surface, key=key, effort="plain", spacings=()))
    return found.id == identity and found.log10_false_positive <= SURE
