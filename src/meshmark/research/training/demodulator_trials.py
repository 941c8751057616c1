"""Readings of attacked models whose bits are known: what the demodulator learns from and is judged by.

The frame is that of the marked model, a little off and then corrected as the lattice lock does it, so that only
what comes after a successful lock is seen. The shape is the restoration with the best lock, as in extraction.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from meshmark.attacks import find_attack
from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.polar import Bits
from meshmark.errors import CapacityError
from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import CellKeys, Lattice
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.pose import POSE_SIZE, Pose, pose_gradient
from meshmark.ownership.carriers.quantisation import bit_phase, lock_score
from meshmark.ownership.carriers.relief import Relief, Umbrellas, measure_relief
from meshmark.ownership.embedding import embed
from meshmark.ownership.observation import Observation
from meshmark.ownership.parameters import CARRIER_READABLE, LONGEST_SAMPLE
from meshmark.ownership.phase_correction import best_correction, corrected_phase
from meshmark.ownership.search.measurement import read_cells
from meshmark.ownership.search.restoration import Restoration, restorations

__all__ = ["ATTACKED", "LOST", "Marked", "Trial", "mark", "trials"]

# Attacks that leave the model in place, so that its frame is known.
ATTACKED: Final = (
    ("float32", 1.0),
    ("noise", 0.002),
    ("noise", 0.005),
    ("noise", 0.01),
    ("noise", 0.02),
    ("smoothing", 10.0),
    ("smoothing", 30.0),
    ("smoothing", 50.0),
    ("smoothing_half", 10.0),
    ("quantisation", 7.0),
    ("simplification", 0.95),
)
# How well the lock finds the frame: shift and scale, turn; canonical units. A reading starts this far off.
POSE_EXPECTED: Final = np.array([5e-3, 5e-3, 5e-3, 5e-3, 6e-3, 6e-3, 6e-3])
POSE_OFF: Final = 0.1
LOCK_PASSES: Final = 2
# A step towards another shape from which the answer of the offsets is taken.
HALF: Final = 0.5
# With more errors than this the frame was not found, and the reading shows nothing.
LOST: Final = 0.36


@dataclass(frozen=True, eq=False, kw_only=True)
class Marked:
    """A marked model and all that its marker knows."""

    mesh: Mesh
    frame: Frame
    lattice: Lattice
    step: float
    codec: Codec
    bits: Bits
    identity: int

    def keys(self, cells: Cells) -> CellKeys:
        """Return what the key says of these cells."""
        return self.lattice.keys(cells.nodes)

    def phase(self, cells: Cells) -> FloatArray:
        """Return the phases (n,) of these cells."""
        return bit_phase(cells.offset, self.keys(cells).dither, self.step)


@dataclass(frozen=True, eq=False, kw_only=True)
class Trial:
    """One reading after an attack, and the truth: targets (n,) +1 for bit 0, -1 for bit 1, 0 for pilots."""

    attack: str
    strength: float
    seen: Observation
    targets: FloatArray


def mark(mesh: Mesh, rng: np.random.Generator, strength: str = "standard") -> Marked | None:
    """Return the model marked with a drawn key and id, or None where its cells have no room for a mark."""
    key, identity = Key(rng.bytes(32)), int.from_bytes(rng.bytes(8), "big")
    try:
        owned = embed(mesh, key, id=identity, strength=strength)
    except CapacityError:
        return None
    if owned.mark.at_points:  # such marks are read without the network
        return None
    surface = weld(owned.mesh)
    codec = Codec(key)
    return Marked(
        mesh=owned.mesh,
        frame=canonical_frame(surface.points, surface.faces),
        lattice=Lattice.keyed(key, owned.mark.spacing, owned.mark.label),
        step=owned.mark.step,
        codec=codec,
        bits=codec.encode(identity),
        identity=identity,
    )


def trials(
    marked: Marked, rng: np.random.Generator, attacks: Sequence[tuple[str, float]] = ATTACKED
) -> Iterator[Trial]:
    """Yield for each attack the readings, of the shape as it is and as restored, that find the mark."""
    for name, strength in attacks:
        surface = weld(find_attack(name)(marked.mesh, strength, rng))
        off = POSE_OFF * POSE_EXPECTED * rng.normal(size=POSE_SIZE)
        starts = [
            _Shape(surface, restoration, off) for restoration in restorations(surface, frame_known=True)
        ]
        scores = [start.score(marked) for start in starts]
        for index in sorted({0, int(np.argmax(scores))}):
            trial = _trial(marked, starts[index], name, strength)
            if trial is not None:
                yield trial


class _Shape:
    """A restoration of an attacked model: how far towards its other shapes, and in which pose."""

    def __init__(self, surface: Surface, restoration: Restoration, off: FloatArray) -> None:
        self._faces, self._joined = surface.faces, surface.connectivity
        first, *others = (shape.points for shape in restoration.shapes)
        self._first, self._ways = first, [other - first for other in others]
        self._expected = np.concatenate([POSE_EXPECTED, restoration.expected])
        self._shares = np.array(restoration.middle)
        self._pose = Pose.turned(np.eye(3)).then(off)

    def cells(self, marked: Marked) -> Cells:
        """Read the cells of the shape as it stands."""
        return self._read(marked, self._points())

    def score(self, marked: Marked) -> float:
        """Return how far the lock stands out, in standard deviations."""
        cells = self.cells(marked)
        if len(cells.nodes) < CARRIER_READABLE:
            return -np.inf
        phase = marked.phase(cells)
        response = self._response(marked, cells)
        phase = phase + response @ self._correction(phase, response, marked.keys(cells))
        keys = marked.keys(cells)
        return float(lock_score(keys.factor * phase, keys.weight)) / float(np.sqrt(len(phase) / 2.0))

    def lock(self, marked: Marked, cells: Cells) -> None:
        """Correct shares and pose as the lattice lock does, given the cells of the shape as it stands."""
        response = self._response(marked, cells)
        correction = self._correction(marked.phase(cells), response, marked.keys(cells))
        self._pose = self._pose.then(correction[:POSE_SIZE])
        self._shares = self._shares + correction[POSE_SIZE:]

    def relief(self, marked: Marked, cells: Cells) -> Relief:
        """Measure the relief around the cells."""
        canonical = marked.frame.to_canonical(self._points())
        placed = marked.lattice.coordinates(self._pose(canonical))
        return measure_relief(placed, Umbrellas.of(placed, self._joined), cells)

    def _points(self) -> FloatArray:
        return self._first + sum(
            (share * way for share, way in zip(self._shares, self._ways, strict=True)),
            np.zeros_like(self._first),
        )

    def _read(self, marked: Marked, points: FloatArray) -> Cells:
        placed = marked.frame.to_canonical(points)
        samples = plan_samples(placed, self._faces, LONGEST_SAMPLE * marked.lattice.spacing)(placed)
        return read_cells(samples, marked.lattice, self._pose)

    def _response(self, marked: Marked, cells: Cells) -> FloatArray:
        """Return the change of the phases (n, d) per unit of each part of a correction."""
        columns = [pose_gradient(cells, marked.lattice)]
        for way in self._ways:
            after = self._read(marked, self._points() + HALF * way)
            row = find_nodes(after.nodes, cells.nodes)
            change = np.zeros(len(row))
            change[row >= 0] = after.offset[row[row >= 0]] - cells.offset[row >= 0]
            columns.append(change[:, None] / HALF)
        return np.asarray(2.0 * np.pi / marked.step * np.hstack(columns))

    def _correction(self, phase: FloatArray, response: FloatArray, keys: CellKeys) -> FloatArray:
        turned = keys.factor[:, None] * response * self._expected
        ones = np.ones(response.shape[1])
        return self._expected * best_correction(keys.factor * phase, turned, ones, keys.weight)


def _trial(marked: Marked, shape: _Shape, name: str, strength: float) -> Trial | None:
    for _ in range(LOCK_PASSES):
        cells = shape.cells(marked)
        if len(cells.nodes) < CARRIER_READABLE:
            return None
        shape.lock(marked, cells)
    cells = shape.cells(marked)
    seen = Observation(
        phase=marked.phase(cells),
        cells=cells,
        keys=marked.keys(cells),
        step=marked.step,
        relief=shape.relief(marked, cells),
    )
    targets = np.where(seen.keys.pilot, 0.0, 1.0 - 2.0 * marked.bits[seen.keys.code_index])
    carries_bit = targets != 0.0
    if np.mean(np.cos(corrected_phase(seen)[carries_bit]) * targets[carries_bit] < 0.0) > LOST:
        return None
    return Trial(attack=name, strength=strength, seen=seen, targets=targets)
