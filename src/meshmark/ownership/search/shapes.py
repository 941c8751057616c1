"""What the cells of a suspect's possible shapes say, and how they answer to a correction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.frame import Frame, canonical_frame, frame_alternatives
from meshmark.geometry.sampling import Sampler, Samples, gathered, plan_samples
from meshmark.geometry.weld import Welded
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.pose import POSE_SIZE, Pose, pose_gradient
from meshmark.ownership.carriers.relief import Relief, measure_relief
from meshmark.ownership.carriers.selection import select_cells
from meshmark.ownership.parameters import EXTRACT_SELECTION, GATHER, LONGEST_SAMPLE
from meshmark.ownership.search.reading import place
from meshmark.ownership.search.restoration import Restoration

__all__ = ["Response", "Shapes"]


@dataclass(frozen=True, eq=False)
class Response:
    """Cells, and the change of their offsets (n, d), in spacings, per unit of each part of a correction."""

    cells: Cells
    gradient: FloatArray
    relief: Relief


class Shapes:
    """Shapes of one suspect; what was measured once is kept for the next.

    Each lies in the frame of its own, or all lie in a `fixed` one.
    """

    def __init__(self, surface: Welded, fixed: Frame | None = None) -> None:
        self._faces, self._fixed = surface.faces, fixed
        self._frames: dict[int, tuple[FloatArray, Frame]] = {}
        # With the points, so that their number stays theirs.
        self._samples: dict[tuple[int, float], tuple[FloatArray, Samples]] = {}
        self._samplers: dict[float, Sampler] = {}
        self._cells: dict[tuple[int, float, bytes], Cells] = {}

    def frame(self, points: FloatArray) -> Frame:
        """Return the frame of a shape."""
        if self._fixed is not None:
            return self._fixed
        if id(points) not in self._frames:
            self._frames[id(points)] = points, canonical_frame(points, self._faces)
        return self._frames[id(points)][1]

    def samples(self, points: FloatArray, spacing: float) -> Samples:
        """Return the canonical samples of a shape."""
        name = id(points), spacing
        if name not in self._samples:
            canonical = self.frame(points).to_canonical(points)
            longest = LONGEST_SAMPLE * spacing
            if spacing not in self._samplers:  # shapes of one suspect are alike: one plan does for all
                self._samplers[spacing] = plan_samples(canonical, self._faces, longest)
            samples = gathered(self._samplers[spacing](canonical), GATHER * longest)
            self._samples[name] = points, samples
        return self._samples[name][1]

    def cells(self, points: FloatArray, lattice: Lattice, turned: Frame) -> Cells:
        """Return all cells of a shape, its frame turned as `turned` is."""
        pose = self._pose(points, turned)
        name = id(points), lattice.spacing, (np.round(pose.turn) + 0.0).tobytes()
        if name not in self._cells:
            self._cells[name] = place(self.samples(points, lattice.spacing), lattice, pose)
        return self._cells[name]

    def carriers(self, points: FloatArray, lattice: Lattice, turned: Frame) -> Cells:
        """Return those cells of a shape that may carry."""
        cells = self.cells(points, lattice, turned)
        return cells.take(select_cells(cells, EXTRACT_SELECTION))

    def response(self, restoration: Restoration, lattice: Lattice, turned: Frame) -> Response:
        """Measure a restoration in the middle of what is expected."""
        first, *others = restoration.shapes
        start = self.carriers(first, lattice, turned)
        seen = np.ones(len(start.nodes), dtype=bool)
        changes = []
        for other in others:
            cells = self.cells(other, lattice, turned)
            row = find_nodes(cells.nodes, start.nodes)
            seen &= row >= 0
            changes.append(cells.offset[row] - start.offset)
        index = np.flatnonzero(seen)
        start = start.take(index)
        change = np.array(changes).reshape(len(others), len(seen))[:, index].T
        offset = start.offset + change @ np.array(restoration.middle)
        cells = Cells(start.nodes, offset, start.normal, start.mass, start.flatness)
        ways = zip(restoration.middle, others, strict=True)
        points = first + sum((share * (other - first) for share, other in ways), np.zeros_like(first))
        relief = self._relief(first, points, lattice, self._pose(first, turned), cells)
        return Response(cells, np.hstack([pose_gradient(cells, lattice), change]), relief)

    def corrected(
        self, restoration: Restoration, lattice: Lattice, turned: Frame, correction: FloatArray
    ) -> Response:
        """Measure a restoration anew where a correction, of a pose and then of shares, puts it."""
        first, *others = restoration.shapes
        shares = np.array(restoration.middle) + correction[POSE_SIZE:]
        points = first + sum(share * (other - first) for share, other in zip(shares, others, strict=True))
        pose = self._pose(points, turned).then(correction[:POSE_SIZE])
        cells = place(self.samples(points, lattice.spacing), lattice, pose)
        cells = cells.take(select_cells(cells, EXTRACT_SELECTION))
        relief = self._relief(points, points, lattice, pose, cells)
        return Response(cells, pose_gradient(cells, lattice), relief)

    def _relief(
        self, framed: FloatArray, points: FloatArray, lattice: Lattice, pose: Pose, cells: Cells
    ) -> Relief:
        """Measure the relief of points in the frame of `framed`, brought to a pose."""
        canonical = self.frame(framed).to_canonical(points)
        placed = pose.scale * canonical @ pose.turn + pose.shift
        return measure_relief(lattice.coordinates(placed), self._faces, cells)

    def _pose(self, points: FloatArray, turned: Frame) -> Pose:
        """Return the turn from a shape's own frame to that of its alternatives which is nearest to `turned`."""
        if self._fixed is not None:
            return Pose.turned(np.eye(3))
        own = self.frame(points)
        nearest = max(
            frame_alternatives(own, exchange=True), key=lambda other: float((other.axes * turned.axes).sum())
        )
        return Pose.turned(own.axes.T @ nearest.axes)
