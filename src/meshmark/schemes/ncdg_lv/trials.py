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
from meshmark.carriers.cells import Cells
from meshmark.carriers.lattice import CellKeys, Lattice
from meshmark.carriers.pose import Pose, pose_gradient
from meshmark.carriers.quantisation import bit_phase, lock_score
from meshmark.carriers.relief import Relief, measure_relief
from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.polar import Bits
from meshmark.errors import CapacityError
from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.weld import Welded, weld
from meshmark.mesh import FloatArray, Mesh
from meshmark.schemes.ncdg_lv.embedding import embed
from meshmark.schemes.ncdg_lv.extraction import find
from meshmark.schemes.ncdg_lv.parameters import CARRIER_READABLE, LONGEST_SAMPLE
from meshmark.schemes.ncdg_lv.reading import read_cells
from meshmark.schemes.ncdg_lv.restoration import restorations
from meshmark.schemes.ncdg_lv.settling import settled, settled_phase

__all__ = ["ATTACKED", "Marked", "Trial", "mark", "trials"]

# Attacks that leave the model in place, so that its frame is known.
ATTACKED: Final = (
    ("float32", 1.0),
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
# Between two restored shapes, these shares of the way are read.
SHARES: Final = (0.0, 0.5)
# How well the lock finds the frame: shift and scale, turn; canonical units. A reading starts this far off.
POSE_EXPECTED: Final = np.array([5e-3, 5e-3, 5e-3, 5e-3, 6e-3, 6e-3, 6e-3])
POSE_OFF: Final = 0.1
# With more errors than this the frame was not found, and the reading shows nothing.
LOST: Final = 0.36


@dataclass(frozen=True, eq=False)
class Marked:
    """A marked model and all that its marker knows."""

    mesh: Mesh
    frame: Frame
    lattice: Lattice
    step: float
    codec: Codec
    bits: Bits
    identity: int


@dataclass(frozen=True, eq=False)
class Trial:
    """One reading (see `Reading`) after an attack, and the truth: targets (n,) +1 for bit 0, -1 for bit 1."""

    attack: str
    strength: float
    phase: FloatArray
    cells: Cells
    keys: CellKeys
    step: float
    relief: Relief
    targets: FloatArray


def mark(mesh: Mesh, rng: np.random.Generator, strength: str = "standard") -> Marked | None:
    """Return the model marked with a drawn key and id, or None where it has no room for a mark."""
    key, identity = Key(rng.bytes(32)), int.from_bytes(rng.bytes(8), "big")
    try:
        marked = embed(mesh, key, id=identity, strength=strength).mesh
    except CapacityError:
        return None
    reading = find(marked, key).reading
    surface = weld(marked)
    if reading is None:
        return None
    frame = canonical_frame(surface.points, surface.faces)
    codec = Codec(key)
    lattice = Lattice.keyed(key, reading.spacing)
    return Marked(marked, frame, lattice, reading.step, codec, codec.encode(identity), identity)


def trials(
    marked: Marked, rng: np.random.Generator, attacks: Sequence[tuple[str, float]] = ATTACKED
) -> Iterator[Trial]:
    """Yield for each attack the readings, of the shape as it is and as restored, that find the mark."""
    for name, strength in attacks:
        surface = weld(find_attack(name)(marked.mesh, strength, rng))
        start = Pose.turned(np.eye(3)).then(POSE_OFF * POSE_EXPECTED * rng.normal(size=len(POSE_EXPECTED)))
        shapes = list(_shapes(surface))
        scores = [_score(marked, shape, surface, start) for shape in shapes]
        for index in sorted({0, int(np.argmax(scores))}):
            trial = _trial(marked, shapes[index], surface, start, name, strength)
            if trial is not None:
                yield trial


def _shapes(surface: Welded) -> Iterator[FloatArray]:
    """Yield points (p, 3) as they are, then as restorations make them."""
    for restoration in restorations(surface, False):
        first, *others = restoration.shapes
        for share in SHARES if others else (0.0,):
            yield first + share * sum((other - first for other in others), np.zeros_like(first))


def _cells(marked: Marked, points: FloatArray, surface: Welded, pose: Pose) -> tuple[Cells, CellKeys]:
    placed = marked.frame.to_canonical(points)
    samples = plan_samples(placed, surface.faces, LONGEST_SAMPLE * marked.lattice.spacing)(placed)
    cells = read_cells(samples, marked.lattice, pose)
    return cells, marked.lattice.keys(cells.nodes, marked.codec.n)


def _correction(marked: Marked, cells: Cells, phase: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the small pose (7,) that the lock adds, and the phases with it."""
    response = 2.0 * np.pi / marked.step * pose_gradient(cells, marked.lattice)
    pose = settled(2.0 * phase, 2.0 * response, POSE_EXPECTED)
    return pose, np.asarray(phase + response @ pose)


def _score(marked: Marked, points: FloatArray, surface: Welded, pose: Pose) -> float:
    """Return how far the lock stands out, in standard deviations."""
    cells, keys = _cells(marked, points, surface, pose)
    if len(cells.nodes) < CARRIER_READABLE:
        return -np.inf
    _, phase = _correction(marked, cells, bit_phase(cells.offset, keys.dither, marked.step))
    return float(lock_score(phase)) / float(np.sqrt(len(phase) / 2.0))


def _trial(
    marked: Marked, points: FloatArray, surface: Welded, pose: Pose, name: str, strength: float
) -> Trial | None:
    for _ in range(2):
        cells, keys = _cells(marked, points, surface, pose)
        if len(cells.nodes) < CARRIER_READABLE:
            return None
        small, _ = _correction(marked, cells, bit_phase(cells.offset, keys.dither, marked.step))
        pose = pose.then(small)
    cells, keys = _cells(marked, points, surface, pose)
    placed = pose.scale * marked.frame.to_canonical(points) @ pose.turn + pose.shift
    relief = measure_relief(marked.lattice.coordinates(placed), surface.faces, cells)
    phase = bit_phase(cells.offset, keys.dither, marked.step)
    targets = 1.0 - 2.0 * marked.bits[keys.code_index].astype(np.float64)
    if np.mean(np.cos(settled_phase(phase, cells, marked.step, relief)) * targets < 0.0) > LOST:
        return None
    return Trial(name, strength, phase, cells, keys, marked.step, relief, targets)
