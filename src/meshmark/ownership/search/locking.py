"""Readings of a suspect whose frame has drifted: each restoration of its shape, corrected by the lattice lock."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from meshmark.coding.keys import Key
from meshmark.geometry.frame import Frame, frame_alternatives
from meshmark.geometry.weld import Welded
from meshmark.ownership.carriers.grown_lock import neighbourhoods
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lock import LockSearch
from meshmark.ownership.carriers.quantisation import bit_phase, log10_lock_chance
from meshmark.ownership.parameters import (
    CARRIER_ENOUGH,
    CARRIER_READABLE,
    CREDIBLE_LOG10,
    LARGE_STEPS,
    LOCK_CANDIDATES,
    LOCK_EXPECTED,
    LOCK_RADIUS,
    LOCK_STEPS,
    LOCK_TURNS,
    ORIGINAL_SPACINGS,
    SURELY_SKEW,
    TYPICAL_STEP,
    preferred_spacings,
)
from meshmark.ownership.search.reading import Reading
from meshmark.ownership.search.relocking import grown_locks, relocked
from meshmark.ownership.search.restoration import Restoration, restorations, stretched
from meshmark.ownership.search.shapes import Response, Shapes

__all__ = ["locked_readings", "registered_readings", "stretched_readings"]

# Clusters of cells that a stretch is looked for from.
CLUSTERS = 3
# Corrections tried in each: twelve directions need more than seven.
STRETCH_GRID = 1_000_000
# The frames of stretched shapes have followed: so much of the usual drift is left. A registration has to make do
# with a stretched suspect: it is off by more.
STRETCH_DRIFT, REGISTERED_DRIFT = 0.6, 1.6


def locked_readings(
    surface: Welded,
    key: Key,
    code_length: int,
    tickets: Iterator[int],
    wide: bool = False,
    spacings: Sequence[float] | None = None,
) -> Iterator[Reading]:
    """Yield the best few corrected readings of each restoration, spacing and turn, likeliest first.

    tickets: numbers of readings, which all share one bound.
    """
    shapes = Shapes(surface)
    for restoration in restorations(surface):
        frame = shapes.frame(restoration.shapes[0])
        for spacing in _spacings(shapes, restoration, frame, key, wide) if spacings is None else spacings:
            lattice = Lattice.keyed(key, spacing)
            turns = frame_alternatives(frame, wide, SURELY_SKEW)
            for turned in turns if wide else islice(turns, LOCK_TURNS):
                yield from _locked(
                    shapes, restoration, lattice, turned, LOCK_STEPS, code_length, next(tickets)
                )


def stretched_readings(
    surface: Welded,
    key: Key,
    code_length: int,
    tickets: Iterator[int],
    wide: bool = False,
    spacings: Sequence[float] | None = None,
) -> Iterator[Reading]:
    """Yield readings of the suspect as it was before a small stretch, whose lock is credible.

    A stretch moves cells by many steps; grown from a cluster that hardly feels it, the lock finds it all the same.
    """
    shapes, restoration = Shapes(surface), stretched(surface.points)
    frame = shapes.frame(surface.points)
    steps = LOCK_STEPS if wide else LOCK_STEPS[:LARGE_STEPS]
    for spacing in _spacings(shapes, restoration, frame, key, wide) if spacings is None else spacings:
        lattice = Lattice.keyed(key, spacing)
        turns = frame_alternatives(frame, wide, SURELY_SKEW)
        for turned in turns if wide else islice(turns, LOCK_TURNS):
            yield from _grown(
                shapes, restoration, lattice, turned, steps, STRETCH_DRIFT, code_length, next(tickets)
            )


def registered_readings(
    surface: Welded,
    key: Key,
    code_length: int,
    tickets: Iterator[int],
    frames: Sequence[Frame],
    spacings: Sequence[float] | None,
    steps: Sequence[float] | None,
) -> Iterator[Reading]:
    """Yield corrected readings in frames that a reference gave, as `locked_readings` does in the suspect's own.

    spacings, steps: of the lattice and the quantiser, where the reference tells them.
    """
    held = []
    for frame in frames:
        near = preferred_spacings(frame.area)[:ORIGINAL_SPACINGS] if spacings is None else spacings
        shapes = Shapes(surface, frame)
        held += [(frame, shapes, Lattice.keyed(key, spacing)) for spacing in near]
    known = LOCK_STEPS if steps is None else steps
    for restoration in restorations(surface) if held else ():
        for frame, shapes, lattice in held:
            yield from _locked(shapes, restoration, lattice, frame, known, code_length, next(tickets))
    restoration = stretched(surface.points)
    for frame, shapes, lattice in held:
        yield from _grown(
            shapes, restoration, lattice, frame, known, REGISTERED_DRIFT, code_length, next(tickets)
        )


def _spacings(
    shapes: Shapes, restoration: Restoration, frame: Frame, key: Key, wide: bool
) -> Iterator[float]:
    """Yield the first spacing with carriers enough, or all such; none where the shape has fallen apart."""
    for spacing in preferred_spacings(frame.area):
        carriers = shapes.carriers(restoration.shapes[0], Lattice.keyed(key, spacing), frame)
        if len(carriers.nodes) < CARRIER_ENOUGH:
            continue
        yield spacing
        if not wide:
            return


def _locked(
    shapes: Shapes,
    restoration: Restoration,
    lattice: Lattice,
    turned: Frame,
    steps: Sequence[float],
    code_length: int,
    number: int,
) -> Iterator[Reading]:
    """Yield the best corrections over all steps; after one that is credible, also what is measured there anew.

    number: of these readings among all; each pays for the corrections of all steps.
    """
    response = shapes.response(restoration, lattice, turned)
    if len(response.cells.nodes) < CARRIER_READABLE:
        return
    keys = lattice.keys(response.cells.nodes, code_length)
    expected = np.concatenate([LOCK_EXPECTED, restoration.expected])
    rough = []
    tried = 0.0
    for step in steps:
        phase = bit_phase(response.cells.offset, keys.dither, step)
        gradient = 4.0 * np.pi / step * response.gradient
        search = LockSearch(2.0 * phase, gradient, expected, LOCK_RADIUS)
        tried += search.tried
        for lock in search.rough(LOCK_CANDIDATES):
            chance = log10_lock_chance(lock.score, len(phase)) + float(np.log10(lock.tried))
            rough.append((chance, step, search, lock))
    charge = number * (number + 1) * tried
    for _, step, search, lock in sorted(rough, key=lambda entry: entry[0])[:LOCK_CANDIDATES]:
        correction = search.polished([lock])[0].correction
        phase = bit_phase(response.cells.offset + response.gradient @ correction, keys.dither, step)
        reading = Reading.of(lattice.spacing, step, response.cells, keys, phase, charge)
        reading = replace(reading, relief=response.relief)
        yield reading
        if reading.log10_chance + np.log10(tried) < CREDIBLE_LOG10:
            yield _again(
                shapes.corrected(restoration, lattice, turned, correction), lattice, step, code_length, charge
            )


def _grown(
    shapes: Shapes,
    restoration: Restoration,
    lattice: Lattice,
    turned: Frame,
    steps: Sequence[float],
    drift: float,
    code_length: int,
    number: int,
) -> Iterator[Reading]:
    """Yield what locks from any of a few clusters of cells on; drift: over the usual one."""
    response = shapes.response(restoration, lattice, turned)
    if len(response.cells.nodes) < CARRIER_READABLE:
        return
    keys = lattice.keys(response.cells.nodes, code_length)
    expected = np.concatenate([LOCK_EXPECTED * drift, restoration.expected])
    places = response.cells.nodes.astype(np.float64)
    typical = 4.0 * np.pi / TYPICAL_STEP * response.gradient
    orders = neighbourhoods(typical * expected, places, CLUSTERS)
    locks = grown_locks(response.cells, keys, response.gradient, expected, steps, orders, STRETCH_GRID)
    for step, correction, tried in locks:
        anew = shapes.corrected(restoration, lattice, turned, correction)
        yield _again(anew, lattice, step, code_length, number * (number + 1) * tried)


def _again(response: Response, lattice: Lattice, step: float, code_length: int, charge: float) -> Reading:
    """Return the best reading close to where this response was measured."""
    keys = lattice.keys(response.cells.nodes, code_length)
    phase, _, tried = relocked(response.cells, keys, response.gradient, step)
    reading = Reading.of(lattice.spacing, step, response.cells, keys, phase, charge * tried)
    return replace(reading, relief=response.relief)
