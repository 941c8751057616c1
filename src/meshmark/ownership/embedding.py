"""Embedding: from a mesh, a key and an id to the marked mesh, read back before it is returned."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, log10, sqrt
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.message import check_id, random_id
from meshmark.coding.polar import Bits
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.geometry.weld import Welded, weld
from meshmark.io.save import conform
from meshmark.mesh import Mesh
from meshmark.ownership.extraction import Found, find
from meshmark.ownership.parameters import (
    BUDGET_SHARE,
    CARRIER_ENOUGH,
    CARRIER_MINIMUM,
    HOPELESS_BITS,
    SPACING_TRIES,
    STEP_TRIES,
    STEPS,
    preferred_spacings,
)
from meshmark.ownership.results import Embedding
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import TrialCounter
from meshmark.ownership.shaping import Shaping
from meshmark.ownership.shortfall import why_not
from meshmark.strengths import BUDGETS
from meshmark.threads import on_one_thread

__all__ = ["diagonal_of", "displacement_rms", "embed"]


@dataclass(frozen=True, eq=False, kw_only=True)
class _Attempt:
    mesh: Mesh
    rms: float
    found: Found
    spacing: float
    step: float


@on_one_thread
def embed(
    mesh: Mesh, key: Key, *, id: int | None = None, strength: str = "standard", reserve: float = 0.0
) -> Embedding:
    """Return `mesh` carrying a 64-bit id under `key`; without an id a random one is drawn.

    strength: "subtle", "standard" or "strong", an RMS displacement of at most 0.02, 0.08 or 0.2 % of the
    bounding-box diagonal (of the vertices that faces use). The first of a few steps, from the largest that seems
    within the budget down, is taken whose mark, rounded to what the file can hold, is read back blind.
    reserve: RMS over the diagonal that a layer on top of this one needs of the budget.

    Raises `InputError` for arguments that cannot be used, `CapacityError` where the mesh cannot carry 64 bits.
    """
    start = perf_counter()
    identity = random_id() if id is None else check_id(id)
    _check(strength, reserve)
    codec = Codec(key)
    bits = codec.encode(identity)
    diagonal = diagonal_of(mesh)
    budget = sqrt(BUDGETS[strength] ** 2 - reserve**2) * diagonal
    surface = weld(mesh)
    frame = canonical_frame(surface.points, surface.faces)
    nearest: tuple[tuple[bool, int], str] | None = None
    for shaping in _shapings(surface, frame, key, bits):
        carriers = shaping.carriers if shaping.capacity >= CARRIER_MINIMUM else shaping.capacity
        tried = carriers >= CARRIER_MINIMUM and shaping.bits >= HOPELESS_BITS
        if nearest is None or (tried, carriers) > nearest[0]:
            reason = why_not(shaping.surroundings, carriers, shaping.capacity, strength, tried)
            nearest = (tried, carriers), reason
        if not tried:
            continue
        # Marking changes the area by far less than this.
        likeliest = {preferred_spacings(frame.area * change)[0] for change in (0.97, 1.03)} == {
            shaping.spacing
        }
        attempt = _largest_step(mesh, surface, key, identity, shaping, budget, likeliest)
        if attempt is not None:
            return _finish(mesh, attempt, identity, strength, diagonal, perf_counter() - start)
    raise CapacityError(
        nearest[1] if nearest is not None else "the model has no surface that could carry 64 bits"
    )


def _check(strength: str, reserve: float) -> None:
    if strength not in BUDGETS:
        raise InputError(f"unknown strength '{strength}', expected one of {', '.join(BUDGETS)}")
    if not 0.0 <= reserve < BUDGETS[strength]:
        raise InputError(
            f"a reserve of {reserve:g} is out of range, expected 0 to the budget {BUDGETS[strength]:g}"
        )


def _shapings(surface: Welded, frame: Frame, key: Key, bits: Bits) -> Iterator[Shaping]:
    """Yield the first few spacings with carriers enough, then those passed over, most carriers first."""
    rich, scarce = 0, []
    for spacing in preferred_spacings(frame.area):
        shaping = Shaping(surface, frame, key, spacing, bits)
        if shaping.capacity < CARRIER_ENOUGH:
            scarce.append(shaping)
            continue
        yield shaping
        rich += 1
        if rich == SPACING_TRIES:
            break
    yield from sorted(scarce, key=lambda shaping: -shaping.capacity)


def _largest_step(
    mesh: Mesh, surface: Welded, key: Key, identity: int, shaping: Shaping, budget: float, likeliest: bool
) -> _Attempt | None:
    """Return the mark of largest step within the budget that is read back, or None.

    likeliest: the spacing is the first that an extraction reads, so reading it alone is all it would do.
    """

    def affordable(step: float) -> bool:
        return shaping.rms(step) <= BUDGET_SHARE * budget

    first = bisect_left(STEPS, True, key=affordable)
    for step in STEPS[first : first + 2 * STEP_TRIES : 2]:
        points = shaping.shaped(float(step))
        moved = (points != surface.points).any(axis=1)[surface.point_of_vertex]
        vertices = np.where(moved[:, None], points[surface.point_of_vertex], mesh.vertices)
        marked = mesh.with_vertices(conform(mesh, vertices))
        rms = displacement_rms(mesh, marked)
        if rms > budget:
            continue
        search = Search(surface=weld(marked), key=key, effort="plain")
        # One spacing fails sooner than all would.
        found = find(replace(search, spacings=(shaping.spacing,)))
        if found.id == identity and not likeliest:
            found = find(replace(search, trials=TrialCounter()))
        if found.id == identity:
            return _Attempt(mesh=marked, rms=rms, found=found, spacing=shaping.spacing, step=float(step))
    return None


def _used(mesh: Mesh) -> NDArray[np.bool_]:
    """Return (n,): the vertices that faces use; stray ones must not stretch the budget."""
    used = np.zeros(len(mesh.vertices), dtype=bool)
    used[mesh.faces.ravel()] = True
    return used


def diagonal_of(mesh: Mesh) -> float:
    """Return the diagonal of the box around the vertices that faces use, in scene units."""
    return float(np.linalg.norm(np.ptp(mesh.vertices[_used(mesh)], axis=0)))


def displacement_rms(mesh: Mesh, other: Mesh) -> float:
    """Return the RMS distance, in scene units, of vertices that faces use from their places in `other`."""
    moved = (other.vertices - mesh.vertices)[_used(mesh)]
    return float(np.sqrt(np.einsum("ij,ij->", moved, moved) / len(moved)))


def _finish(
    mesh: Mesh,
    attempt: _Attempt,
    identity: int,
    strength: str,
    diagonal: float,
    seconds: float,
) -> Embedding:
    largest = float(np.linalg.norm(attempt.mesh.vertices - mesh.vertices, axis=1).max())
    return Embedding(
        mesh=attempt.mesh,
        id=identity,
        layers="ownership",
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
        carriers=attempt.found.carriers,
        mark_vertices=0,
        payload_bytes=0,
        rms_over_diagonal=attempt.rms / diagonal,
        max_over_diagonal=largest / diagonal,
        psnr_db=20.0 * log10(diagonal / attempt.rms) if attempt.rms > 0.0 else inf,
        verified=True,
        seconds=seconds,
        strength=strength,
        spacing=attempt.spacing,
        step=attempt.step,
    )
