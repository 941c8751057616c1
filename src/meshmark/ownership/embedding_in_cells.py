"""The id in the cells of a surface: the toughest mark within what may be moved and seen, read back blind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import CapacityError
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of_moved
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.embedding_task import EmbeddingTask, Owned
from meshmark.ownership.extraction import find
from meshmark.ownership.ownership_mark import OwnershipMark
from meshmark.ownership.parameters import (
    BUDGET_SHARE,
    CARRIER_ENOUGH,
    CARRIER_MINIMUM,
    HOPELESS_BITS,
    LONG_EDGES,
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
from meshmark.ownership.shortfall import Counted, Surroundings, too_long, what, why_not
from meshmark.ownership.vertex_displacement import displacement_rms

__all__ = ["embed_in_cells"]

# Loudness of a mark of the middle step, at least: where hardly any patch changes it is 0.
QUIETEST = 1e-3


def embed_in_cells(task: EmbeddingTask, *, still: NDArray[np.bool_] | None = None) -> Owned:
    """Return the first mark that is read back, of a few lattices and steps, the one that bears most noise first.

    still: (p,) points that stay where they are. Raises `CapacityError` that says what the cells lack.
    """
    frame = task.surface.frame
    patch = preferred_spacings(frame.area)[0] * frame.scale
    longest = task.surface.mean_face_length / patch
    if longest > LONG_EDGES[1]:
        raise CapacityError(too_long(longest, task.bits, task.strength))
    nearest: tuple[Surroundings, Counted, bool] | None = None
    least = CARRIER_MINIMUM[task.bits]
    for shaping in _shapings(task, one=longest > LONG_EDGES[0], still=still):
        carriers = shaping.carriers if shaping.capacity >= least else shaping.capacity
        tried = carriers >= least and shaping.bits >= HOPELESS_BITS[task.bits]
        if nearest is None or (tried, carriers) > (nearest[2], nearest[1].carriers):
            counted = Counted(
                bits=task.bits, carriers=carriers, capacity=shaping.capacity, strength=task.strength
            )
            nearest = shaping.surroundings, counted, tried
        if tried and (found := _read_back(task, shaping)) is not None:
            return found
    if nearest is None:
        raise CapacityError(f"the model has no surface that could carry {what(task.bits)}")
    raise CapacityError(why_not(*nearest))


def _shapings(task: EmbeddingTask, *, one: bool, still: NDArray[np.bool_] | None) -> Iterator[Shaping]:
    """Yield the first few spacings with carriers enough, then those passed over, most carriers first.

    one: the first only.
    """
    surface = task.surface
    spacings = preferred_spacings(surface.frame.area)
    rich, scarce = 0, []
    for spacing in spacings:
        lattice = Lattice.keyed(task.key, spacing, task.label)
        shaping = Shaping(
            surface, lattice, task.word, task.seen, task.share, typical=task.typical_word, still=still
        )
        if shaping.capacity < CARRIER_ENOUGH:
            scarce.append(shaping)
            continue
        yield shaping
        rich += 1
        if one:
            return
        if rich == SPACING_TRIES:
            break
    yield from sorted(scarce, key=lambda shaping: -shaping.capacity)


def _read_back(task: EmbeddingTask, shaping: Shaping) -> Owned | None:
    """Return the first mark that is read back, from the toughest step down, or None."""
    surface = task.surface
    likeliest = _is_likeliest(surface, shaping.lattice.spacing)
    first = _toughest(task, shaping)
    for step in STEPS[first : first + STEP_TRIES]:
        points = shaping.shaped(float(step))
        marked = task.moved(points)
        if displacement_rms(task.mesh, marked) > task.budget:
            continue
        search = Search(surface=surface_of_moved(marked, task.mesh), key=task.key, effort="plain")
        # One spacing fails sooner than all would.
        found = find(replace(search, spacings=(shaping.lattice.spacing,)))
        if found.id == task.identity and not likeliest:
            found = find(replace(search, trials=TrialCounter()))
        if found.id == task.identity:
            mark = OwnershipMark(
                carriers=found.carriers,
                frame=surface.frame,
                label=shaping.lattice.label,
                spacing=shaping.lattice.spacing,
                step=float(step),
                bits=task.bits,
            )
            return Owned(mesh=marked, mark=mark, folded=shaping.surroundings.folded)
    return None


def _toughest(task: EmbeddingTask, shaping: Shaping) -> int:
    """Return the index of the step within the budget that bears most noise; their number where none does."""

    def worth(index: int) -> tuple[float, float]:
        step = float(STEPS[index])
        if shaping.rms(step) > BUDGET_SHARE * task.budget:
            return -1.0, 0.0
        borne = shaping.borne(step) / task.diagonal
        return min(borne, TYPICAL_NOISE), shaping.expected_cosine(step, TYPICAL_NOISE * task.diagonal)

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
