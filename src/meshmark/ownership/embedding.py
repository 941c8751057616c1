"""Embedding of the ownership layer: from a mesh, a key and an id to the marked mesh, read back blind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.message import check_id, random_id
from meshmark.coding.polar import Bits
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of, surface_of_moved
from meshmark.geometry.visibility import VisibleChange
from meshmark.io.file_precision import conform
from meshmark.mesh import Mesh
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.extraction import find
from meshmark.ownership.ownership_mark import OwnershipMark
from meshmark.ownership.parameters import (
    BUDGET_SHARE,
    CARRIER_ENOUGH,
    CARRIER_MINIMUM,
    HOPELESS_BITS,
    SPACING_TRIES,
    STEP_TRIES,
    STEPS,
    TYPICAL_LOUDNESS,
    TYPICAL_NOISE,
    preferred_spacings,
)
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import TrialCounter
from meshmark.ownership.shaping import Shaping
from meshmark.ownership.shortfall import why_not
from meshmark.ownership.vertex_displacement import diagonal_of, displacement_rms
from meshmark.strengths import BUDGETS, VISIBLE_SHARES, check_strength
from meshmark.threads import on_one_thread

__all__ = ["Owned", "embed"]

# Loudness of a mark of the middle step, at least: where hardly any patch changes it is 0.
QUIETEST = 1e-3


@dataclass(frozen=True, eq=False, kw_only=True)
class Owned:
    """A mesh with a mark of the ownership layer."""

    mesh: Mesh
    mark: OwnershipMark


@dataclass(frozen=True, eq=False, kw_only=True)
class _Task:
    """What is to be marked, within which RMS displacement (scene units) and visible share of the surface."""

    mesh: Mesh
    surface: Surface
    key: Key
    identity: int
    diagonal: float
    budget: float
    share: float


@on_one_thread
def embed(
    mesh: Mesh, key: Key, *, id: int | None = None, strength: str = "standard", reserve: float = 0.0
) -> Owned:
    """Put a 64-bit id into a mesh, as tough as the strength allows.

    The first of a few steps, from the one that bears most noise within the budget down, is taken whose mark,
    rounded to what the file can hold, is read back blind.

    Parameters
    ----------
    mesh : Mesh
    key : Key
    id : int, optional
        64 bits; drawn at random where it is left out.
    strength : str
        "subtle", "standard" or "strong": visible on about 0.3, 2.5 or 20 % of the surface, with an RMS displacement
        of at most 0.02, 0.08 or 0.2 % of the bounding-box diagonal of the vertices that faces use.
    reserve : float
        RMS over the diagonal that a layer on top of this one needs of the budget.

    Returns
    -------
    Owned

    Raises
    ------
    InputError
        An argument cannot be used.
    CapacityError
        The mesh cannot carry 64 bits.
    """
    identity = random_id() if id is None else check_id(id)
    budget = BUDGETS[check_strength(strength)]
    if not 0.0 <= reserve < budget:
        raise InputError(f"a reserve of {reserve:g} is out of range, expected 0 to the budget {budget:g}")
    bits = Codec(key).encode(identity)
    diagonal = diagonal_of(mesh)
    surface = surface_of(mesh)
    task = _Task(
        mesh=mesh,
        surface=surface,
        key=key,
        identity=identity,
        diagonal=diagonal,
        budget=sqrt(budget**2 - reserve**2) * diagonal,
        share=VISIBLE_SHARES[strength],
    )
    nearest: tuple[tuple[bool, int], str] | None = None
    for shaping in _shapings(task, bits):
        carriers = shaping.carriers if shaping.capacity >= CARRIER_MINIMUM else shaping.capacity
        tried = carriers >= CARRIER_MINIMUM and shaping.bits >= HOPELESS_BITS
        if nearest is None or (tried, carriers) > nearest[0]:
            reason = why_not(shaping.surroundings, carriers, shaping.capacity, strength, tried)
            nearest = (tried, carriers), reason
        if tried and (found := _read_back(task, shaping)) is not None:
            return found
    raise CapacityError(
        nearest[1] if nearest is not None else "the model has no surface that could carry 64 bits"
    )


def _shapings(task: _Task, bits: Bits) -> Iterator[Shaping]:
    """Yield the first few spacings with carriers enough, then those passed over, most carriers first."""
    surface = task.surface
    spacings = preferred_spacings(surface.frame.area)
    label = Label.of_shape(surface.invariants, task.key)
    seen = VisibleChange(surface.points, surface.faces)
    rich, scarce = 0, []
    for spacing in spacings:
        shaping = Shaping(surface, Lattice.keyed(task.key, spacing, label), bits, seen, task.share)
        if shaping.capacity < CARRIER_ENOUGH:
            scarce.append(shaping)
            continue
        yield shaping
        rich += 1
        if rich == SPACING_TRIES:
            break
    yield from sorted(scarce, key=lambda shaping: -shaping.capacity)


def _read_back(task: _Task, shaping: Shaping) -> Owned | None:
    """Return the first mark that is read back, from the toughest step down, or None."""
    mesh, surface = task.mesh, task.surface
    likeliest = _is_likeliest(surface, shaping.spacing)
    first = _toughest(task, shaping)
    for step in STEPS[first : first + STEP_TRIES]:
        points = shaping.shaped(float(step))
        moved = (points != surface.points).any(axis=1)[surface.point_of_vertex]
        vertices = np.where(moved[:, None], points[surface.point_of_vertex], mesh.vertices)
        marked = mesh.with_vertices(conform(mesh, vertices))
        if displacement_rms(mesh, marked) > task.budget:
            continue
        search = Search(surface=surface_of_moved(marked, mesh), key=task.key, effort="plain")
        # One spacing fails sooner than all would.
        found = find(replace(search, spacings=(shaping.spacing,)))
        if found.id == task.identity and not likeliest:
            found = find(replace(search, trials=TrialCounter()))
        if found.id == task.identity:
            mark = OwnershipMark(
                carriers=found.carriers, label=shaping.label, spacing=shaping.spacing, step=float(step)
            )
            return Owned(mesh=marked, mark=mark)
    return None


def _toughest(task: _Task, shaping: Shaping) -> int:
    """Return the index of the step within the budget that bears most noise; their number where none does."""

    def worth(index: int) -> tuple[float, float]:
        step = float(STEPS[index])
        if shaping.rms(step) > BUDGET_SHARE * task.budget:
            return -1.0, 0.0
        borne = shaping.borne(step) / task.diagonal
        return min(borne, TYPICAL_NOISE), shaping.told(step, TYPICAL_NOISE * task.diagonal)

    # Loudness is about proportional to the step.
    middle = float(STEPS[len(STEPS) // 2])
    likely = middle * TYPICAL_LOUDNESS / max(shaping.loudness(middle), QUIETEST)
    best = int(np.argmin(np.abs(np.log(STEPS / likely))))
    values = {best: worth(best)}
    while best < len(STEPS):
        for index in (best - 1, best + 1):
            if 0 <= index < len(STEPS) and index not in values:
                values[index] = worth(index)
        ahead = max(values, key=lambda index: (values[index], index))
        if ahead == best and values[best][0] >= 0.0:
            break
        best = ahead if ahead != best else best + 1
    return best


def _is_likeliest(surface: Surface, spacing: float) -> bool:
    """Return whether a spacing is the first that an extraction reads, so that no other need be tried."""
    # Marking changes the area by far less than this.
    return {preferred_spacings(surface.frame.area * change)[0] for change in (0.97, 1.03)} == {spacing}
