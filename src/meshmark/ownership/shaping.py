"""Shaping a surface so that its cells say the code bits: a Newton solve for the bumps.

To first order the frame stays where it is (its nine moments are constraints like any cell's offset); after that
distinct axes are followed and alike ones held, so that the cells an extraction finds are the ones that were shaped.
"""

from __future__ import annotations

from functools import cached_property
from math import log2

import numpy as np

from meshmark.coding.keys import Key
from meshmark.coding.polar import Bits
from meshmark.geometry.areas import vertex_areas
from meshmark.geometry.frame import Frame
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.surface import Surface
from meshmark.geometry.visibility import Visibility, VisibleChange
from meshmark.mesh import FloatArray
from meshmark.ownership import x_experiment as X
from meshmark.ownership.bumps import FRAME_ROWS, Bumps, frame_values, symmetric
from meshmark.ownership.carriers.cells import Cells, measure_cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.quantisation import nearest_offsets
from meshmark.ownership.carriers.selection import select_cells
from meshmark.ownership.compensation import compensated
from meshmark.ownership.parameters import (
    ALIKE,
    DIVERGED,
    EMBED_SELECTION,
    EXTRACT_SELECTION,
    HOPELESS_ERROR,
    LONGEST_SAMPLE,
    LOST_ERROR,
    MOMENT_GAP,
    SOLVE_PASSES,
    SOLVE_TOLERANCE,
)
from meshmark.ownership.shortfall import Surroundings, surroundings_of

__all__ = ["Shaping"]


class Shaping:
    """One surface, lattice and word of code bits.

    capacity: how many cells an extraction of the unmarked surface would read; cheap, where `carriers` is not.
    """

    def __init__(self, surface: Surface, frame: Frame, key: Key, spacing: float, bits: Bits) -> None:
        self._surface, self._frame, self._bits, self.spacing = surface, frame, bits, spacing
        self._lattice = Lattice.keyed(key, spacing)
        self._placed = self._lattice.coordinates(frame.to_canonical(surface.points))
        self._sampler = plan_samples(self._placed, surface.faces, LONGEST_SAMPLE)
        self._samples = self._sampler(self._placed)
        cells = measure_cells(self._samples)
        read, chosen = select_cells(cells, EXTRACT_SELECTION), select_cells(cells, EMBED_SELECTION)
        self.capacity = len(read)
        self._candidates, self._read_too = cells.take(chosen), np.isin(chosen, read)
        self._all = cells
        self._changes = {}

    @property
    def carriers(self) -> int:
        """How many of the cells that an extraction reads can be set, given how many vertices there are to move."""
        return int((self._bumps.free & self._read_too).sum())

    @property
    def bits(self) -> float:
        """The most bits that hard decisions can yield: cells that cannot be set are right half of the time."""
        wrong = 0.5 * (1.0 - self.carriers / max(self.capacity, 1))
        lost = sum(-share * log2(share) for share in (wrong, 1.0 - wrong) if share > 0.0)
        return self.capacity * (1.0 - lost)

    @property
    def surroundings(self) -> Surroundings:
        """What the cells see of the surface, to say why there are too few that carry."""
        return surroundings_of(self._all, self._placed, self._surface.faces)

    def rms(self, step: float) -> float:
        """Return the first-order RMS displacement in scene units, over vertices or over area: the larger.

        Where few vertices span most of the surface, a small mean over vertices could hide a large dent.
        """
        length = self._bumps.displacement(self._frame_change, self._change(step))
        means = (length * length) @ np.column_stack([self._copies, self._areas])
        return float(np.sqrt(means.max())) * self._unit

    def visibility(self, step: float) -> Visibility:
        """Return how visible the mark of this step is, to first order."""
        length = self._bumps.displacement(self._frame_change, self._change(step))
        return self._visible_change.of(self._placed + length[:, None] * self._bumps.normals)

    @cached_property
    def _visible_change(self) -> VisibleChange:
        return VisibleChange(self._placed, self._surface.faces)

    def shaped(self, step: float) -> FloatArray:
        """Return scene positions (p, 3) that carry the bits at this step, as well as the surface lets them.

        Newton's method with the gradient of the start, which stays good as bumps are small against windows. A
        cell whose error grows, on an edge or a fold, is let go before it drags its neighbours along; the best
        pass is kept.
        """
        change = self._change(step)
        target = self._cells.offset + change
        length = self._bumps.displacement(self._frame_change, change)
        held = np.ones(len(target), dtype=bool)
        previous = np.full(len(target), np.inf)
        best, best_error = length, np.inf
        for turn in range(SOLVE_PASSES):
            offsets, drift = self._read(self._placed + length[:, None] * self._bumps.normals)
            error = (target - offsets) / step
            adrift = self._shift(drift) / step
            total = float(np.minimum(np.abs(error) + adrift, LOST_ERROR).sum())
            if total < best_error:
                best, best_error = length, total
            elif total > DIVERGED * best_error:
                break
            if turn >= 2 and best_error > HOPELESS_ERROR * len(target):
                break
            far = np.abs(error) >= SOLVE_TOLERANCE
            if adrift < SOLVE_TOLERANCE and not (far & held).any():
                break
            held &= ~far | (np.abs(error) < previous)
            previous = np.abs(error)
            length = length + self._bumps.bend(drift)
            if (far & held).any():
                corrected = np.where(held, error, 0.0) * step
                length = length + self._bumps.displacement(np.zeros(FRAME_ROWS), corrected)
        return self._surface.points + (best * self._unit)[:, None] * self._scene_normals

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
    def _copies(self) -> FloatArray:
        """Share of the file's vertices that each point stands for (p,)."""
        copies = np.bincount(self._surface.point_of_vertex, minlength=len(self._surface.points))
        copies[self._areas == 0.0] = 0
        return np.asarray(copies / copies.sum())

    @cached_property
    def _areas(self) -> FloatArray:
        """Share of the surface that each point stands for (p,)."""
        areas = vertex_areas(self._placed, self._surface.faces)
        return np.asarray(areas / areas.sum())

    @cached_property
    def _cells(self) -> Cells:
        return self._candidates.take(np.flatnonzero(self._bumps.free))

    def _change(self, step: float) -> FloatArray:
        """Return (f,): the changes of offset, in spacings, that put every free cell on its bit."""
        keys = self._lattice.keys(self._cells.nodes)
        bits = self._bits[keys.code_index].astype(np.int64)
        whole = nearest_offsets(self._cells.offset, keys.dither, bits, step, self._bumps.cost)
        if step not in self._changes:
            self._changes[step] = compensated(whole, step, self._bumps.cost, self._excess)
            self.told = float(np.cos(2*np.pi*(whole-self._changes[step])/step).mean()), float(np.cos(4*np.pi*(whole-self._changes[step])/step).mean())
        return self._changes[step]

    def _excess(self, change: FloatArray) -> FloatArray:
        length = self._bumps.displacement(self._frame_change, change)
        ratio = self._visible_change.ratios(self._placed + length[:, None] * self._bumps.normals)
        return (self._patches @ ratio**4) ** 0.25, float((ratio > 1.0).mean())

    @cached_property
    def _patches(self) -> FloatArray:
        """Share (f, patches) of each patch in what is seen of each cell."""
        cells, visible = self._cells, self._visible_change
        places = cells.nodes + cells.offset[:, None] * cells.normal
        square = ((places[:, None, :] - self._placed[visible.centres]) ** 2).sum(axis=2)
        facing = np.maximum(cells.normal @ self._bumps.normals[visible.centres].T, 0.0)
        weight = np.exp(-0.5 * square / X.NEAR**2) * facing + 1e-12
        return weight / weight.sum(axis=1, keepdims=True)

    @cached_property
    def _frame_change(self) -> FloatArray:
        """Change of the frame values (9,), canonical units, that keeps the principal axes apart."""
        ramp = MOMENT_GAP * np.array([2.0, 1.0, 0.0])
        apart = np.maximum.accumulate((self._frame.moments - ramp)[::-1])[::-1] + ramp
        change = np.zeros(FRAME_ROWS)
        change[3:6] = apart / apart.sum() - self._frame.moments
        return change

    def _read(self, placed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the free cells' offsets (f,), and how far the frame values (9,) are from where they are held.

        Distinct axes hardly turn: they are followed, offsets are read in the frame that the shaped surface has of
        its own, and nothing is held. Axes that are nearly alike turn at a touch: they are held.
        """
        points = self._lattice.points(placed)
        values = frame_values(points, self._surface.faces)
        drift = np.zeros(FRAME_ROWS)
        if -np.diff(self._frame.moments).max() < ALIKE:
            drift[3:6] = self._frame.moments
            drift += self._frame_change - values
        else:
            moments, axes = np.linalg.eigh(symmetric(values[3:]))
            axes = axes[:, ::-1]
            axes = axes * np.where(np.diag(axes) < 0.0, -1.0, 1.0)
            placed = self._lattice.coordinates((points - values[:3]) @ (axes / np.sqrt(moments.sum())))
        cells = measure_cells(self._sampler(placed))
        found = find_nodes(cells.nodes, self._cells.nodes)
        return np.where(found >= 0, cells.offset[found], self._cells.offset), drift

    def _shift(self, drift: FloatArray) -> float:
        """Return how far such a drift of the frame moves a typical cell, in spacings.

        A mixed moment turns the axes by itself over the difference of their moments.
        """
        xx, yy, zz = self._frame.moments + self._frame_change[3:6]
        turns = np.abs(drift[6:] / np.array([xx - yy, xx - zz, yy - zz]))
        moved = np.concatenate([np.abs(drift[:6]), turns])
        return float(np.sqrt((moved**2).sum() / 3.0)) / self._lattice.spacing
