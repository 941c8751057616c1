"""What is measured on a surface under one hypothesis of its frame, and what a quantisation step reads there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from meshmark.geometry.sampling import Samples
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells, measure_cells
from meshmark.ownership.carriers.lattice import CellKeys, Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.pose import Pose
from meshmark.ownership.carriers.quantisation import (
    bit_phase,
    lock_score,
    log10_lock_chance,
)
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.carriers.selection import select_cells
from meshmark.ownership.observation import Observation
from meshmark.ownership.parameters import EXTRACT_SELECTION

if TYPE_CHECKING:
    from meshmark.ownership.carriers.relief import Relief

__all__ = ["CellReading", "Measurement", "place", "read_cells"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Measurement:
    """n cells of a lattice of one spacing (in canonical units), measured in one frame.

    label: of the lattice. keys: what the key says of them. relief: measures that of the surface, where the network
    is to demodulate: only of readings that are decoded.
    """

    label: Label
    spacing: float
    cells: Cells
    keys: CellKeys
    relief: Callable[[], Relief] | None = None

    @classmethod
    def of(cls, lattice: Lattice, cells: Cells, relief: Callable[[], Relief] | None = None) -> Measurement:
        """Return the measurement of these cells."""
        keys = lattice.keys(cells.nodes)
        return cls(label=lattice.label, spacing=lattice.spacing, cells=cells, keys=keys, relief=relief)

    def __len__(self) -> int:
        return len(self.cells.nodes)

    def psi(self, step: float | FloatArray, shift: FloatArray | float = 0.0) -> FloatArray:
        """Return the phases (n,) times 1 or 2, so that they do not depend on bits."""
        return self.keys.factor * self.phase(step, shift)

    def turn(self, gradient: FloatArray, step: float) -> FloatArray:
        """Return the change of `psi` (n, d) for a change of the offsets (n, d), in spacings."""
        return (2.0 * np.pi / step) * self.keys.factor[:, None] * gradient

    def phase(self, step: float | FloatArray, shift: FloatArray | float = 0.0) -> FloatArray:
        """Return the phases (n,), radians, at a step in spacings, the offsets shifted by `shift` (n,)."""
        return bit_phase(self.cells.offset + shift, self.keys.dither, step)


@dataclass(frozen=True, eq=False, kw_only=True)
class CellReading(Reading):
    """Cells read with one quantisation step.

    measured: whose phases they are.
    """

    measured: Measurement

    @classmethod
    def of(cls, measured: Measurement, step: float, phase: FloatArray, hypotheses: float) -> CellReading:
        """Score these phases."""
        score = float(lock_score(measured.keys.factor * phase, measured.keys.weight))
        return cls(
            measured=measured,
            label=measured.label,
            spacing=measured.spacing,
            keys=measured.keys,
            step=step,
            phase=phase,
            score=score,
            log10_chance=log10_lock_chance(score, len(phase)),
            hypotheses=hypotheses,
        )

    def observation(self, relief: Relief) -> Observation:
        """Return what the reading shows of each cell."""
        measured = self.measured
        return Observation(
            phase=self.phase, cells=measured.cells, keys=measured.keys, step=self.step, relief=relief
        )

    def ratios(self) -> FloatArray:
        """Return the log-likelihood ratio (n,) of the bit of each cell."""
        if self.measured.relief is None:
            return super().ratios()
        from meshmark.ownership.demodulator import demodulate

        return demodulate(self.observation(self.measured.relief()))


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
        positions=samples.positions @ (turn * size) + shift,
        vectors=samples.vectors @ (turn * size**2),
        areas=samples.areas * size**2,
    )
    return measure_cells(placed)
