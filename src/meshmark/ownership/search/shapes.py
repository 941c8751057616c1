"""What the cells of a suspect's possible shapes say, and how they answer to a correction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from weakref import WeakKeyDictionary

import numpy as np

from meshmark.geometry.areas import face_lengths
from meshmark.geometry.frame import Frame, canonical_frame, frame_alternatives
from meshmark.geometry.invariants import shape_invariants
from meshmark.geometry.sampling import Sampler, SamplerPlans, Samples, gathered
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.pose import POSE_SIZE, Pose, pose_gradient
from meshmark.ownership.carriers.relief import Relief, Umbrellas, measure_relief
from meshmark.ownership.carriers.selection import select_cells
from meshmark.ownership.parameters import EXTRACT_SELECTION, GATHER, LONGEST_SAMPLE
from meshmark.ownership.search.measurement import Measurement, place, read_cells
from meshmark.ownership.search.restoration import Restoration, Shape

__all__ = ["Hypothesis", "Response", "Shapes"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Hypothesis:
    """What a suspect may have been: a restoration of its shape, and how its frame is turned on a lattice."""

    restoration: Restoration
    lattice: Lattice
    turned: Frame


@dataclass(frozen=True, eq=False)
class Response:
    """A measurement, and the change of its offsets (n, d), in spacings, per unit of each part of a correction."""

    measured: Measurement
    gradient: FloatArray

    def __len__(self) -> int:
        return len(self.measured)


class Shapes:
    """Measures the shapes that one suspect may have had; what was measured is kept as long as the shape.

    Each lies in the frame of its own, or all lie in a `fixed` one. longest: of their samples, in spacings.
    """

    def __init__(
        self, surface: Surface, fixed: Frame | None = None, *, longest: float = LONGEST_SAMPLE
    ) -> None:
        self._faces, self._fixed, self._longest = surface.faces, fixed, longest
        self._joined = surface.connectivity
        self._frames: WeakKeyDictionary[Shape, Frame] = WeakKeyDictionary()
        self._invariants: WeakKeyDictionary[Shape, FloatArray] = WeakKeyDictionary()
        self._samples: WeakKeyDictionary[Shape, dict[float, Samples]] = WeakKeyDictionary()
        self._cells: WeakKeyDictionary[Shape, dict[tuple[float, str, bytes], Cells]] = WeakKeyDictionary()
        self._plans: SamplerPlans | None = None
        self._middles: WeakKeyDictionary[Restoration, tuple[FloatArray, Umbrellas]] = WeakKeyDictionary()
        self._sampled: WeakKeyDictionary[Shape, tuple[Sampler, Samples]] = WeakKeyDictionary()

    def frame(self, shape: Shape) -> Frame:
        """Return the frame of a shape."""
        if self._fixed is not None:
            return self._fixed
        if shape.framed_by is not None:
            return self.frame(shape.framed_by)
        if shape not in self._frames:
            self._frames[shape] = canonical_frame(shape.points, self._faces)
        return self._frames[shape]

    def invariants(self, shape: Shape) -> FloatArray:
        """Return the invariants of a shape, or of the one in whose frame it lies; frames are not fixed."""
        if shape.framed_by is not None:
            return self.invariants(shape.framed_by)
        if shape not in self._invariants:
            self._invariants[shape] = shape_invariants(shape.points, self._faces, self.frame(shape))
        return self._invariants[shape]

    def middle_invariants(self, restoration: Restoration) -> FloatArray:
        """Return about the invariants of a restoration in the middle of what is expected."""
        first = self.invariants(restoration.shapes[0])
        ways = zip(restoration.middle, restoration.shapes[1:], strict=True)
        changes = [share * (self.invariants(other) - first) for share, other in ways if share]
        return np.asarray(first + np.sum(changes, axis=0)) if changes else first

    def samples(self, shape: Shape, spacing: float) -> Samples:
        """Return the canonical samples of a shape."""
        known = self._samples.setdefault(shape, {})
        if spacing not in known:
            canonical = self.frame(shape).to_canonical(shape.points)
            longest = self._longest * spacing
            if self._plans is None:  # shapes of one suspect are alike: one plan does for all
                self._plans = SamplerPlans(self._faces, face_lengths(canonical, self._faces))
            sampler = self._plans.plan(canonical, longest)
            if shape not in self._sampled or self._sampled[shape][0] is not sampler:
                self._sampled.clear()  # those of one shape at a time: they take more room than the shape
                self._sampled[shape] = sampler, sampler(canonical)
            known[spacing] = gathered(self._sampled[shape][1], GATHER * longest)
        return known[spacing]

    def cells(self, shape: Shape, lattice: Lattice, turned: Frame) -> Cells:
        """Return all cells of a shape, its frame turned as `turned` is."""
        pose = self._pose(shape, turned)
        known = self._cells.setdefault(shape, {})
        name = lattice.spacing, str(lattice.label), (np.round(pose.turn) + 0.0).tobytes()
        if name not in known:
            known[name] = place(self.samples(shape, lattice.spacing), lattice, pose)
        return known[name]

    def carriers(self, shape: Shape, lattice: Lattice, turned: Frame) -> Cells:
        """Return those cells of a shape that may carry."""
        cells = self.cells(shape, lattice, turned)
        return cells.take(select_cells(cells, EXTRACT_SELECTION))

    def response(self, hypothesis: Hypothesis) -> Response:
        """Measure a hypothesis in the middle of what is expected."""
        restoration, lattice, turned = hypothesis.restoration, hypothesis.lattice, hypothesis.turned
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
        cells = Cells(
            nodes=start.nodes, offset=offset, normal=start.normal, mass=start.mass, flatness=start.flatness
        )
        pose = self._pose(first, turned)

        @cache
        def relief() -> Relief:
            return _relief(*self._middle(restoration), cells, lattice, pose)

        gradient = np.hstack([pose_gradient(cells, lattice), change])
        return Response(Measurement.of(lattice, cells, relief), gradient)

    def _middle(self, restoration: Restoration) -> tuple[FloatArray, Umbrellas]:
        """Return canonical points (p, 3) of a restoration in the middle of what is expected, and their moves."""
        if restoration not in self._middles:
            frame = self.frame(restoration.shapes[0])
            middle = frame.to_canonical(restoration.between(restoration.middle))
            self._middles[restoration] = middle, Umbrellas.of(middle, self._joined)
        return self._middles[restoration]

    def corrected(self, hypothesis: Hypothesis, correction: FloatArray) -> Response:
        """Measure a hypothesis anew where a correction, of a pose and then of shares, puts it."""
        restoration, lattice = hypothesis.restoration, hypothesis.lattice
        shares = np.array(restoration.middle) + correction[POSE_SIZE:]
        shape = Shape(restoration.between(shares), restoration.shapes[0].framed_by)
        pose = self._pose(shape, hypothesis.turned).then(correction[:POSE_SIZE])
        cells = read_cells(self.samples(shape, lattice.spacing), lattice, pose)

        @cache
        def relief() -> Relief:
            canonical = self.frame(shape).to_canonical(shape.points)
            return _relief(canonical, Umbrellas.of(canonical, self._joined), cells, lattice, pose)

        return Response(Measurement.of(lattice, cells, relief), pose_gradient(cells, lattice))

    def _pose(self, shape: Shape, turned: Frame) -> Pose:
        """Return the turn from a shape's own frame to that of its alternatives which is nearest to `turned`."""
        if self._fixed is not None:
            return Pose.turned(np.eye(3))
        own = self.frame(shape)
        nearest = max(
            frame_alternatives(own, exchange=True), key=lambda other: float((other.axes * turned.axes).sum())
        )
        return Pose.turned(own.axes.T @ nearest.axes)


def _relief(points: FloatArray, moves: Umbrellas, cells: Cells, lattice: Lattice, pose: Pose) -> Relief:
    """Measure canonical points (p, 3), brought to a pose, around the cells."""
    placed = lattice.coordinates(pose(points))
    return measure_relief(placed, moves.scaled(pose.scale / lattice.spacing), cells)
