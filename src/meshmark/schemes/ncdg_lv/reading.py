"""Reading the lattice off a surface: every hypothesis about frame, spacing and step, and its lock score."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from meshmark.carriers.cells import Cells, measure_cells
from meshmark.carriers.lattice import CellKeys, Lattice
from meshmark.carriers.quantisation import (
    bit_phase,
    lock_score,
    log10_lock_chance,
    log_likelihood_ratio,
)
from meshmark.carriers.selection import select_cells
from meshmark.coding.keys import Key
from meshmark.geometry.frame import Frame, canonical_frame, frame_alternatives
from meshmark.geometry.sampling import Samples, plan_samples
from meshmark.geometry.weld import Welded
from meshmark.mesh import FloatArray
from meshmark.schemes.ncdg_lv.parameters import (
    CARRIER_PLENTY,
    CARRIER_READABLE,
    EXTRACT_SELECTION,
    LONGEST_SAMPLE,
    SPACING_TRIES,
    STEPS,
    preferred_spacings,
)

__all__ = ["Reading", "read_cells", "readings"]


@dataclass(frozen=True, eq=False)
class Reading:
    """The cells under one hypothesis of frame and spacing, at its best quantisation step.

    frame, spacing, step: the hypothesis, the step in spacings.
    phase: (n,) radians; score: sum of cos(2 phase); log10_chance: of the score alone, one hypothesis;
    hypotheses: what this reading's chance is to be multiplied by. The t-th reading is charged (steps) t (t + 1):
    as the 1 / (t (t + 1)) add up to 1, the bound holds for all readings together, wherever the search stops.
    """

    frame: Frame
    spacing: float
    step: float
    cells: Cells
    keys: CellKeys
    phase: FloatArray
    score: float
    log10_chance: float
    hypotheses: int

    def observed(self, code_length: int) -> FloatArray:
        """Return the log-likelihood ratio (code_length,) of each code bit, 0 where no cell carries it."""
        ratio = log_likelihood_ratio(self.phase)
        return np.bincount(self.keys.code_index, ratio, code_length).astype(np.float64)


def readings(
    surface: Welded,
    key: Key,
    code_length: int,
    wide: bool = False,
    spacings: Sequence[float] | None = None,
) -> Iterator[Reading]:
    """Yield a reading for each spacing and frame alternative with enough cells, likeliest first.

    wide: also with axes of nearly equal moments exchanged, and all spacings instead of the first few.
    spacings: those to read; by default all that an embedding may have chosen.
    """
    frame = canonical_frame(surface.points, surface.faces)
    canonical = frame.to_canonical(surface.points)
    tried, rich = 0, 0
    for spacing in preferred_spacings(frame.area) if spacings is None else spacings:
        lattice = Lattice.keyed(key, spacing)
        samples = plan_samples(canonical, surface.faces, LONGEST_SAMPLE * spacing)(canonical)
        fewest = 0
        for other in frame_alternatives(frame, exchange=wide):
            turn = frame.axes.T @ other.axes
            cells, keys = read_cells(samples, lattice, turn, code_length)
            fewest = min(fewest or len(cells.nodes), len(cells.nodes))
            if fewest < CARRIER_READABLE:
                break  # about as many whichever way the lattice lies
            tried += 1
            yield _at_best_step(other, spacing, cells, keys, len(STEPS) * tried * (tried + 1))
        rich += fewest >= CARRIER_PLENTY
        if rich == SPACING_TRIES and not wide:
            return


def read_cells(
    samples: Samples, lattice: Lattice, turn: FloatArray, code_length: int
) -> tuple[Cells, CellKeys]:
    """Return the selected cells of canonical samples turned by `turn` (3, 3), and what the key says of them."""
    axes = turn @ lattice.axes.T
    placed = Samples(
        samples.positions @ (axes / lattice.spacing) + lattice.shift, samples.vectors @ axes, samples.areas
    )
    cells = measure_cells(placed)
    # The flux is in units of area; a plane patch of one spacing squared has mass 1.
    cells = Cells(cells.nodes, cells.offset, cells.normal, cells.mass / lattice.spacing**2, cells.flatness)
    cells = cells.take(select_cells(cells, EXTRACT_SELECTION))
    return cells, lattice.keys(cells.nodes, code_length)


def _at_best_step(frame: Frame, spacing: float, cells: Cells, keys: CellKeys, hypotheses: int) -> Reading:
    phases = bit_phase(cells.offset, keys.dither, STEPS[:, None])
    scores = lock_score(phases)
    best = int(np.argmax(scores))
    score = float(scores[best])
    chance = log10_lock_chance(score, len(cells.nodes))
    return Reading(frame, spacing, float(STEPS[best]), cells, keys, phases[best], score, chance, hypotheses)
