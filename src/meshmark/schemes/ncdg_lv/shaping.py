"""Shaping a surface so that its cells say the code bits: a Newton solve for the bumps.

The frame is held where it is (its nine moments are constraints like any cell's offset), so that the cells an
extraction finds are the ones that were shaped.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from meshmark.carriers.cells import Cells, measure_cells
from meshmark.carriers.lattice import Lattice
from meshmark.carriers.quantisation import nearest_offsets
from meshmark.carriers.selection import find_cells, select_cells
from meshmark.coding.keys import Key
from meshmark.coding.polar import Bits
from meshmark.geometry.frame import Frame
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.weld import Welded
from meshmark.mesh import FloatArray
from meshmark.schemes.ncdg_lv.bumps import FRAME_ROWS, Bumps, frame_values
from meshmark.schemes.ncdg_lv.parameters import (
    EMBED_SELECTION,
    EXTRACT_SELECTION,
    LONGEST_SAMPLE,
    MOMENT_GAP,
    SOLVE_FRAME_TOLERANCE,
    SOLVE_PASSES,
    SOLVE_TOLERANCE,
)

__all__ = ["Shaping"]


class Shaping:
    """One surface, lattice and word of code bits.

    capacity: how many cells an extraction of the unmarked surface would read; cheap, where `carriers` is not.
    """

    def __init__(self, surface: Welded, frame: Frame, key: Key, spacing: float, bits: Bits) -> None:
        self._surface, self._frame, self._bits, self.spacing = surface, frame, bits, spacing
        self._lattice = Lattice.keyed(key, spacing)
        self._placed = self._lattice.coordinates(frame.to_canonical(surface.points))
        self._sampler = plan_samples(self._placed, surface.faces, LONGEST_SAMPLE)
        self._samples = self._sampler(self._placed)
        cells = measure_cells(self._samples)
        self.capacity = len(select_cells(cells, EXTRACT_SELECTION))
        self._candidates = cells.take(select_cells(cells, EMBED_SELECTION))

    @property
    def carriers(self) -> int:
        """How many of the cells can be set, given how many vertices there are to move."""
        return min(self.capacity, len(self._cells.nodes))

    def displacement(self, step: float) -> FloatArray:
        """Return (p,): first-order lengths along the point normals, scene units, for this step in spacings."""
        return self._bumps.displacement(self._frame_change, self._change(step)) * self._unit

    def shaped(self, step: float) -> FloatArray | None:
        """Return scene positions (p, 3) that carry the bits at this step; None where the solve fails.

        Newton's method with the gradient of the start, which stays good as bumps are small against windows.
        """
        cells = self._cells
        target = cells.offset + self._change(step)
        wanted = np.zeros(FRAME_ROWS)
        wanted[3:6] = self._frame.moments
        wanted += self._frame_change
        length = self._bumps.displacement(self._frame_change, self._change(step))
        worst = np.inf
        for _ in range(SOLVE_PASSES):
            placed = self._placed + length[:, None] * self._bumps.normals
            error = target - self._offsets(placed)
            frame_error = wanted - frame_values(self._lattice.points(placed), self._surface.faces)
            previous, worst = worst, float(np.abs(error).max())
            if worst < SOLVE_TOLERANCE * step and np.abs(frame_error).max() < SOLVE_FRAME_TOLERANCE:
                break
            if worst > previous:
                return None
            length = length + self._bumps.displacement(frame_error, error)
        return self._surface.points + (length * self._unit)[:, None] * self._scene_normals

    @property
    def _unit(self) -> float:
        return self._lattice.spacing * self._frame.scale

    @property
    def _scene_normals(self) -> FloatArray:
        return self._bumps.normals @ self._lattice.axes @ self._frame.axes.T

    @cached_property
    def _bumps(self) -> Bumps:
        return Bumps(self._sampler, self._samples, self._candidates, self._placed, self._lattice)

    @cached_property
    def _cells(self) -> Cells:
        return self._candidates.take(np.flatnonzero(self._bumps.free))

    def _change(self, step: float) -> FloatArray:
        """Return (f,): the changes of offset, in spacings, that put every free cell on its bit."""
        keys = self._lattice.keys(self._cells.nodes, len(self._bits))
        bits = self._bits[keys.code_index].astype(np.int64)
        return nearest_offsets(self._cells.offset, keys.dither, bits, step, self._bumps.cost)

    @cached_property
    def _frame_change(self) -> FloatArray:
        """Change of the frame values (9,), canonical units, that keeps the principal axes apart."""
        ramp = MOMENT_GAP * np.array([2.0, 1.0, 0.0])
        apart = np.maximum.accumulate((self._frame.moments - ramp)[::-1])[::-1] + ramp
        change = np.zeros(FRAME_ROWS)
        change[3:6] = apart / apart.sum() - self._frame.moments
        return change

    def _offsets(self, placed: FloatArray) -> FloatArray:
        """Return (f,): the free cells' offsets with the points at these lattice coordinates."""
        cells = measure_cells(self._sampler(placed))
        found = find_cells(cells, self._cells.nodes)
        return np.where(found >= 0, cells.offset[found], self._cells.offset)
