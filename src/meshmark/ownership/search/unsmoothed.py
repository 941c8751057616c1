"""Readings of the cells of a coarse suspect that was smoothed, with what common tools do taken back exactly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, product
from typing import Final

import numpy as np

from meshmark.geometry.frame import Frame, frame_alternatives
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.pose import Pose
from meshmark.ownership.carriers.quantisation import lock_score, log10_lock_chance
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import (
    CARRIER_PLENTY,
    CARRIER_READABLE,
    CREDIBLE_LOG10,
    LABELS,
    LOCK_STEPS,
    LOCK_TURNS,
    LONGEST_SAMPLE,
    SPACING_ORDER,
    SPACING_TRIES,
    SURELY_SKEW,
)
from meshmark.ownership.search.inverse_smoothing import SHAPES
from meshmark.ownership.search.measurement import CellReading, Measurement, read_cells
from meshmark.ownership.search.restoration import Shape
from meshmark.ownership.search.search import Search, leaves_out_cells
from meshmark.ownership.search.shapes import Shapes

__all__ = ["unsmoothed_readings"]

# Shapes are first read with samples up to this long, in spacings. A lock that is credible by the usual ones is less
# likely by chance there than 10^SCREENED (decision 0044); without a mark one in thirty is.
COARSE_SAMPLE, SCREENED = 0.5, -1.5
# Most shapes, spacings and steps that are tried, and most turns of each: two, or with axes exchanged all.
TRIED: Final = SHAPES * len(SPACING_ORDER) * len(LOCK_STEPS)
TURNS: Final = {False: LOCK_TURNS, True: 24}


@dataclass(frozen=True, eq=False, kw_only=True)
class _Guess:
    """A shape that the suspect may have had, in a frame, and how unlikely its lock is at this spacing and step."""

    log10_chance: float
    points: FloatArray
    frame: Frame
    lattice: Lattice
    step: float

    def read(self, search: Search, hypotheses: float) -> Reading:
        """Measure the shape anew, with all samples instead of gathered ones."""
        lattice = self.lattice
        canonical = self.frame.to_canonical(self.points)
        sampler = plan_samples(canonical, search.surface.faces, LONGEST_SAMPLE * lattice.spacing)
        measured = Measurement.of(lattice, read_cells(sampler(canonical), lattice, Pose.turned(np.eye(3))))
        return CellReading.of(measured, self.step, measured.phase(self.step), hypotheses)


def unsmoothed_readings(search: Search) -> Iterator[Reading]:
    """Yield each reading whose lock is credible, of all that may have been done; none of a fine mesh."""
    if not search.is_coarse:
        return
    coarse, usual = Shapes(search.surface, longest=COARSE_SAMPLE), Shapes(search.surface)
    labels = LABELS[search.effort] if search.wide else 1
    tried = TRIED * TURNS[search.wide] * labels
    for before in search.before_smoothing:
        if leaves_out_cells(before) and not search.wide:
            continue
        for guess in _guesses(search, coarse, usual, before):
            if guess.log10_chance + np.log10(tried) < CREDIBLE_LOG10:
                yield guess.read(search, search.trials.charge() * tried)


def _guesses(search: Search, coarse: Shapes, usual: Shapes, before: Surface) -> Iterator[_Guess]:
    """Yield the best step of a surface for each spacing and turn that an embedding may have used.

    coarse: reads all of them, usual: those that may lock.
    """
    shape, frame = Shape(before.points), before.frame
    turns = list(frame_alternatives(frame, search.wide, SURELY_SKEW))
    # Many shapes are tried, and of the right one the first label is the right one nearly always.
    labels = search.labels(before.invariants)[: None if search.wide else 1]
    rich = 0
    for spacing in search.spacings_for(frame.area):
        lattices = [search.lattice(spacing, label) for label in labels]
        count = 0
        for lattice, turned in product(lattices, islice(turns, TURNS[search.wide])):
            carriers = coarse.carriers(shape, lattice, turned)
            count = len(carriers.nodes)
            if count < CARRIER_READABLE:
                break
            if _best_step(lattice, carriers)[0] < SCREENED:
                chance, step = _best_step(lattice, usual.carriers(shape, lattice, turned))
                yield _Guess(
                    log10_chance=chance, points=shape.points, frame=turned, lattice=lattice, step=step
                )
        rich += count >= CARRIER_PLENTY
        if rich == (SPACING_TRIES if search.wide else 1):
            return


def _best_step(lattice: Lattice, carriers: Cells) -> tuple[float, float]:
    """Return log10 of the chance of the lock of the step that locks best, and the step."""
    measured = Measurement.of(lattice, carriers)
    scores = lock_score(measured.psi(np.array(LOCK_STEPS)[:, None]), measured.keys.weight)
    best = int(scores.argmax())
    return log10_lock_chance(float(scores[best]), len(measured)), LOCK_STEPS[best]
