"""Shaping a surface so that its cells say the code bits: a Newton solve for the bumps.

To first order the frame stays where it is (its nine moments are constraints like any cell's offset); after that
distinct axes are followed and alike ones held, so that the cells an extraction finds are the ones that were shaped.
"""

from __future__ import annotations

from functools import cached_property
from math import log2

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from meshmark.coding.polar import Bits
from meshmark.geometry.areas import vertex_areas
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.surface import Surface
from meshmark.geometry.visibility import VisibleChange
from meshmark.mesh import FloatArray
from meshmark.ownership.bumps import FRAME_ROWS, Bumps, frame_values, symmetric
from meshmark.ownership.carriers.cells import Cells, measure_cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.quantisation import nearest_offsets
from meshmark.ownership.carriers.selection import select_cells
from meshmark.ownership.compensation import Compensation, Task
from meshmark.ownership.parameters import (
    ALIKE,
    DIVERGED,
    EMBED_SELECTION,
    EXTRACT_SELECTION,
    HOPELESS_ERROR,
    LONGEST_SAMPLE,
    LOST_ERROR,
    MOMENT_GAP,
    NEEDED_BITS,
    SOLVE_PASSES,
    SOLVE_TOLERANCE,
)
from meshmark.ownership.patch_shares import patch_shares
from meshmark.ownership.shortfall import Surroundings

__all__ = ["Shaping"]

# The solve makes a mark more visible than its first order is, about so much.
SOLVE_EXCESS = 1.05
HALVINGS = 12


class Shaping:
    """One surface, lattice and word of code bits.

    lattice: as it was given.
    capacity: how many cells an extraction of the unmarked surface would read; cheap, where `carriers` is not.
    """

    def __init__(
        self,
        surface: Surface,
        lattice: Lattice,
        bits: Bits,
        seen: VisibleChange,
        share: float,
        *,
        typical: Bits | None = None,
        still: NDArray[np.bool_] | None = None,
    ) -> None:
        """seen: of the surface's points; share: of the surface where the mark may be visible, at most.

        typical: a word by which steps are judged, so that they do not depend on the id; `bits` where left out.
        still: (p,) points that stay where they are; none where it is left out.
        """
        self._still = still
        self._surface, self._frame, self.lattice = surface, surface.frame, lattice
        self._bits, self._seen, self._share = bits, seen, share
        self._typical = bits if typical is None else typical
        self._placed = lattice.coordinates(surface.frame.to_canonical(surface.points))
        self._plans: dict[tuple[float, bytes], Compensation] = {}
        self._sampler = plan_samples(self._placed, surface.faces, LONGEST_SAMPLE)
        self._samples = self._sampler(self._placed)
        cells = measure_cells(self._samples)
        read, chosen = select_cells(cells, EXTRACT_SELECTION), select_cells(cells, EMBED_SELECTION)
        self.capacity = len(read)
        self._candidates, self._read_too = cells.take(chosen), np.isin(chosen, read)
        self._all = cells

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

    def loudness(self, step: float) -> float:
        """Return the 95th percentile of the ratio by which a mark without compensation is seen, 1 just noticed."""
        turned = self._turned(self._whole(step, self._typical))
        return float(np.quantile(self._seen.ratios_of(turned), 0.95))

    def expected_cosine(self, step: float, noise: float) -> float:
        """Return the mean cosine of the phases that a mark of this step leaves under noise.

        noise: standard deviation of each point's motion along its normal, scene units.
        """
        astray = (2.0 * np.pi / step) * self._bumps.spread * (noise / self._unit)
        return float(np.mean(self._plan(step, self._typical).cosine * np.exp(-0.5 * astray**2)))

    def borne(self, step: float) -> float:
        """Return the noise, in the same unit, under which a mark of this step can just be read; 0 where none."""
        needed = np.sqrt(NEEDED_BITS * np.log(2.0) / max(self.carriers, 1))
        low, high = 0.0, 2.0 * step * self._unit / float(np.median(self._bumps.spread))
        if self.expected_cosine(step, 0.0) < needed:
            return 0.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.expected_cosine(step, middle) >= needed else (low, middle)
        return low

    @cached_property
    def surroundings(self) -> Surroundings:
        """What the cells see of the surface, to say why there are too few that carry."""
        return Surroundings(cells=self._all, placed=self._placed, faces=self._surface.faces)

    def rms(self, step: float) -> float:
        """Return the first-order RMS displacement in scene units, over vertices or over area: the larger.

        Where few vertices span most of the surface, a small mean over vertices could hide a large dent.
        """
        length = self._bumps.basis @ self._coefficients(self._plan(step, self._typical).change)
        means = (length * length) @ np.column_stack([self._copies, self._areas])
        return float(np.sqrt(means.max())) * self._unit

    def shaped(self, step: float) -> FloatArray:
        """Return scene positions (p, 3) that carry the bits at this step, as well as the surface lets them.

        Newton's method with the gradient of the start, which stays good as bumps are small against windows. A
        cell whose error grows, on an edge or a fold, is let go before it drags its neighbours along; the best
        pass is kept.
        """
        change = self._plan(step, self._bits).change
        target = self._start + change
        length = self._bumps.basis @ self._coefficients(change)
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
        """Scene units in a spacing."""
        return self.lattice.spacing * self._frame.scale

    @property
    def _scene_normals(self) -> FloatArray:
        return self._bumps.normals @ self.lattice.axes @ self._frame.axes.T

    @cached_property
    def _bumps(self) -> Bumps:
        return Bumps(
            self._sampler, self._samples, self._candidates, self.lattice, self._seen, still=self._still
        )

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

    def _plan(self, step: float, bits: Bits) -> Compensation:
        """Return the changes of offset that tell most of every free cell's bit."""
        name = step, bits.tobytes()
        if name not in self._plans:
            self._plans[name] = Compensation.of(
                Task(
                    change=self._whole(step, bits),
                    step=step,
                    cost=self._bumps.cost,
                    locks=~self.lattice.keys(self._cells.nodes).pilot,
                    seen=self._seen_at_cells,
                    share=self._share,
                )
            )
        return self._plans[name]

    def _whole(self, step: float, bits: Bits) -> FloatArray:
        """Return the changes of offset (f,) that put every free cell on a point of its bit."""
        keys = self.lattice.keys(self._cells.nodes)
        asked = np.where(keys.pilot, 0, bits[keys.code_index]).astype(np.int64)
        return nearest_offsets(self._start, keys.dither, asked, step, self._bumps.cost)

    @cached_property
    def _start(self) -> FloatArray:
        """Offsets (f,) once the frame is bent to where it is held: the bits are put on top of that."""
        return self._cells.offset + self._bumps.followed(self._frame_change)

    def _coefficients(self, change: FloatArray) -> FloatArray:
        """Return coefficients (m,) of the bumps that bend the frame, and change offsets (f,) from there."""
        followed = self._bumps.followed(self._frame_change)
        return self._bumps.coefficients(self._frame_change, followed + change)

    def _seen_at_cells(self, change: FloatArray) -> tuple[FloatArray, float]:
        """Return how visible changes of offset (f,) are at each cell, and on what share of the surface they are."""
        turned = self._turned(change)
        ratio = SOLVE_EXCESS * self._seen.ratios_of(turned)
        return (self._patches @ ratio**4) ** 0.25, float((ratio > 1.0).mean())

    def _turned(self, change: FloatArray) -> FloatArray:
        """Return how the patches' normals (3 s,) change with offsets (f,)."""
        length = self._bumps.basis @ self._coefficients(change)
        return np.asarray(self._unit * (self._slopes @ length))

    @cached_property
    def _slopes(self) -> sp.csr_array:
        """Change of the patches' normals per scene unit of motion along the points' normals, (3 s, p)."""
        return self._seen.slopes(self._scene_normals)

    @cached_property
    def _patches(self) -> FloatArray:
        """Share (f, k) of each patch in what is seen at each cell."""
        centres = self._seen.centres
        return patch_shares(self._cells, self._placed[centres], self._bumps.normals[centres])

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
        points = self.lattice.points(placed)
        values = frame_values(points, self._surface.faces)
        drift = np.zeros(FRAME_ROWS)
        if -np.diff(self._frame.moments).max() < ALIKE:
            drift[3:6] = self._frame.moments
            drift += self._frame_change - values
        else:
            moments, axes = np.linalg.eigh(symmetric(values[3:]))
            axes = axes[:, ::-1]
            axes = axes * np.where(np.diag(axes) < 0.0, -1.0, 1.0)
            placed = self.lattice.coordinates((points - values[:3]) @ (axes / np.sqrt(moments.sum())))
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
        return float(np.sqrt((moved**2).sum() / 3.0)) / self.lattice.spacing
