"""Readings of a suspect whose frame has drifted: each restoration of its shape, corrected by the lattice lock."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from meshmark.carriers.cells import Cells
from meshmark.carriers.lattice import Lattice
from meshmark.carriers.lock import LockSearch
from meshmark.carriers.nodes import find_nodes
from meshmark.carriers.pose import Pose, pose_gradient
from meshmark.carriers.quantisation import bit_phase, log10_lock_chance
from meshmark.carriers.selection import select_cells
from meshmark.coding.keys import Key
from meshmark.geometry.frame import Frame, canonical_frame, frame_alternatives
from meshmark.geometry.sampling import Samples, plan_samples
from meshmark.geometry.weld import Welded
from meshmark.mesh import FloatArray
from meshmark.schemes.ncdg_lv.parameters import (
    CARRIER_ENOUGH,
    CARRIER_READABLE,
    EXTRACT_SELECTION,
    LOCK_CANDIDATES,
    LOCK_EXPECTED,
    LOCK_RADIUS,
    LOCK_STEPS,
    LONGEST_SAMPLE,
    SURELY_SKEW,
    preferred_spacings,
)
from meshmark.schemes.ncdg_lv.reading import Reading, place
from meshmark.schemes.ncdg_lv.restoration import Restoration, restorations

__all__ = ["locked_readings"]


def locked_readings(
    surface: Welded,
    key: Key,
    code_length: int,
    already: int,
    wide: bool = False,
    spacings: Sequence[float] | None = None,
) -> Iterator[Reading]:
    """Yield the best few corrected readings of each restoration, spacing and turn, likeliest first.

    already: readings that were tried before these and share their bound.
    """
    tried = already
    shapes = _Shapes(surface)
    for restoration in restorations(surface, wide):
        frame = shapes.frame(restoration.shapes[0])
        for spacing in _spacings(shapes, restoration, frame, key, wide) if spacings is None else spacings:
            lattice = Lattice.keyed(key, spacing)
            for turned in frame_alternatives(frame, wide, SURELY_SKEW):
                response = shapes.response(restoration, lattice, turned)
                if len(response.cells.nodes) < CARRIER_READABLE:
                    break
                tried += 1
                yield from _locked(response, restoration, lattice, code_length, tried * (tried + 1))


@dataclass(frozen=True, eq=False)
class _Response:
    """Cells, and the change of their offsets (n, d), in spacings, per unit of each part of a correction."""

    cells: Cells
    gradient: FloatArray


class _Shapes:
    """Shapes of one suspect, each in the frame of its own; what was measured once is kept for the next."""

    def __init__(self, surface: Welded) -> None:
        self._faces = surface.faces
        self._frames: dict[int, tuple[FloatArray, Frame]] = {}
        self._samples: dict[tuple[int, float], Samples] = {}
        self._cells: dict[tuple[int, float, bytes], Cells] = {}

    def frame(self, points: FloatArray) -> Frame:
        """Return the canonical frame of a shape."""
        if id(points) not in self._frames:
            self._frames[id(points)] = points, canonical_frame(points, self._faces)
        return self._frames[id(points)][1]

    def samples(self, points: FloatArray, spacing: float) -> Samples:
        """Return the canonical samples of a shape."""
        name = id(points), spacing
        if name not in self._samples:
            canonical = self.frame(points).to_canonical(points)
            self._samples[name] = plan_samples(canonical, self._faces, LONGEST_SAMPLE * spacing)(canonical)
        return self._samples[name]

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

    def response(self, restoration: Restoration, lattice: Lattice, turned: Frame) -> _Response:
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
        return _Response(cells, np.hstack([pose_gradient(cells, lattice), change]))

    def _pose(self, points: FloatArray, turned: Frame) -> Pose:
        """Return the turn from a shape's own frame to that of its alternatives which is nearest to `turned`."""
        own = self.frame(points)
        nearest = max(
            frame_alternatives(own, exchange=True), key=lambda other: float((other.axes * turned.axes).sum())
        )
        return Pose.turned(own.axes.T @ nearest.axes)


def _spacings(
    shapes: _Shapes, restoration: Restoration, frame: Frame, key: Key, wide: bool
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
    response: _Response, restoration: Restoration, lattice: Lattice, code_length: int, charge: int
) -> list[Reading]:
    keys = lattice.keys(response.cells.nodes, code_length)
    expected = np.concatenate([LOCK_EXPECTED, restoration.expected])
    rough = []
    tried = 0.0
    for step in LOCK_STEPS:
        phase = bit_phase(response.cells.offset, keys.dither, step)
        search = LockSearch(2.0 * phase, 4.0 * np.pi / step * response.gradient, expected, LOCK_RADIUS)
        tried += search.tried
        for lock in search.rough(LOCK_CANDIDATES):
            chance = log10_lock_chance(lock.score, len(phase)) + float(np.log10(lock.tried))
            rough.append((chance, float(step), search, lock))
    result = []
    for _, step, search, lock in sorted(rough, key=lambda entry: entry[0])[:LOCK_CANDIDATES]:
        correction = search.polished(lock).correction
        phase = bit_phase(response.cells.offset + response.gradient @ correction, keys.dither, step)
        result.append(Reading.of(lattice.spacing, step, response.cells, keys, phase, charge * tried))
    return result
