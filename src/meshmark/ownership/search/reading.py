"""Reading the lattice off a surface: every hypothesis about frame, spacing and step, and its lock score."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from meshmark.coding.keys import Key
from meshmark.geometry.frame import canonical_frame, frame_alternatives
from meshmark.geometry.sampling import Samples, plan_samples
from meshmark.geometry.weld import Welded
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells, measure_cells
from meshmark.ownership.carriers.lattice import CellKeys, Lattice
from meshmark.ownership.carriers.pose import Pose
from meshmark.ownership.carriers.quantisation import (
    bit_phase,
    lock_score,
    log10_lock_chance,
    log_likelihood_ratio,
)
from meshmark.ownership.carriers.relief import Relief
from meshmark.ownership.carriers.selection import select_cells
from meshmark.ownership.demodulator import demodulate
from meshmark.ownership.parameters import (
    CARRIER_PLENTY,
    CARRIER_READABLE,
    EXTRACT_SELECTION,
    LONGEST_SAMPLE,
    SPACING_TRIES,
    STEPS,
    SURELY_SKEW,
    preferred_spacings,
)

__all__ = ["Reading", "place", "read_cells", "readings"]


@dataclass(frozen=True, eq=False)
class Reading:
    """Cells under one hypothesis of frame, spacing and quantisation step.

    step: in spacings. phase: (n,) radians; score: sum of cos(2 phase); log10_chance: of the score alone, one
    hypothesis; hypotheses: what the chance is to be multiplied by. The t-th reading is charged (hypotheses of its
    own) t (t + 1): as the 1 / (t (t + 1)) add up to 1, the bound holds for all readings together, wherever the
    search stops.
    relief: of the surface, where the network is to demodulate; mirrored: read in the suspect's mirror image.
    """

    spacing: float
    step: float
    cells: Cells
    keys: CellKeys
    phase: FloatArray
    score: float
    log10_chance: float
    hypotheses: float
    relief: Relief | None = None
    mirrored: bool = False

    @classmethod
    def of(
        cls, spacing: float, step: float, cells: Cells, keys: CellKeys, phase: FloatArray, hypotheses: float
    ) -> Reading:
        """Score these phases."""
        score = float(lock_score(phase))
        chance = log10_lock_chance(score, len(phase))
        return cls(spacing, step, cells, keys, phase, score, chance, hypotheses)

    def observed(self, code_length: int) -> FloatArray:
        """Return the log-likelihood ratio (code_length,) of each code bit, 0 where no cell carries it."""
        if self.relief is None:
            ratio = log_likelihood_ratio(self.phase)
        else:
            ratio = demodulate(self.phase, self.cells, self.step, self.relief)
        return np.bincount(self.keys.code_index, ratio, code_length).astype(np.float64)


def readings(
    surface: Welded,
    key: Key,
    code_length: int,
    tickets: Iterator[int],
    wide: bool = False,
    spacings: Sequence[float] | None = None,
) -> Iterator[Reading]:
    """Yield a reading for each spacing and frame alternative with enough cells, likeliest first.

    tickets: numbers of readings, which all share one bound.
    wide: also with axes of nearly equal moments exchanged, and all spacings instead of the first few.
    spacings: those to read; by default all that an embedding may have chosen.
    """
    frame = canonical_frame(surface.points, surface.faces)
    canonical = frame.to_canonical(surface.points)
    rich = 0
    for spacing in preferred_spacings(frame.area) if spacings is None else spacings:
        lattice = Lattice.keyed(key, spacing)
        samples = plan_samples(canonical, surface.faces, LONGEST_SAMPLE * spacing)(canonical)
        fewest = 0
        for other in frame_alternatives(frame, wide, np.inf if wide else SURELY_SKEW):
            cells = read_cells(samples, lattice, Pose.turned(frame.axes.T @ other.axes))
            fewest = min(fewest or len(cells.nodes), len(cells.nodes))
            if fewest < CARRIER_READABLE:
                break  # about as many whichever way the lattice lies
            number = next(tickets)
            yield _at_best_step(spacing, cells, lattice.keys(cells.nodes, code_length), number * (number + 1))
        rich += fewest >= CARRIER_PLENTY
        if rich == SPACING_TRIES and not wide:
            return


def read_cells(samples: Samples, lattice: Lattice, pose: Pose) -> Cells:
    """Return the cells that may carry, of canonical samples brought to `pose`."""
    cells = place(samples, lattice, pose)
    return cells.take(select_cells(cells, EXTRACT_SELECTION))


def place(samples: Samples, lattice: Lattice, pose: Pose) -> Cells:
    """Return all cells of canonical samples brought to `pose`."""
    turn = pose.turn @ lattice.axes.T
    size = pose.scale / lattice.spacing
    shift = pose.shift @ lattice.axes.T / lattice.spacing + lattice.shift
    # A plane patch of one spacing squared has mass 1.
    placed = Samples(
        samples.positions @ (turn * size) + shift, samples.vectors @ (turn * size**2), samples.areas * size**2
    )
    return measure_cells(placed)


def _at_best_step(spacing: float, cells: Cells, keys: CellKeys, charge: int) -> Reading:
    phases = bit_phase(cells.offset, keys.dither, STEPS[:, None])
    best = int(np.argmax(lock_score(phases)))
    return Reading.of(spacing, float(STEPS[best]), cells, keys, phases[best], len(STEPS) * charge)
