"""Made-up readings, for tests."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import CellKeys
from meshmark.ownership.carriers.relief import Relief
from meshmark.ownership.observation import Observation

STEP = 0.12


def reading(count: int = 220, seed: int = 0, *, pilots: float = 0.2) -> Observation:
    """Cells around a sphere of radius 5 spacings, with answers to bending of very different sizes; phases of 0.

    pilots: about this share of the cells.
    """
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=(count, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    cells = Cells(
        nodes=np.round(5.0 * normal).astype(np.int64),
        offset=rng.uniform(-0.4, 0.4, count),
        normal=normal,
        mass=rng.uniform(0.4, 1.0, count),
        flatness=rng.uniform(0.7, 1.0, count),
    )
    relief = Relief(rng.normal(size=(count, 2)) * 0.02, np.exp(rng.normal(size=count)) * 0.01)
    keys = CellKeys(
        code_index=np.arange(count), dither=rng.uniform(size=count), pilot=rng.random(count) < pilots
    )
    return Observation(phase=np.zeros(count), cells=cells, keys=keys, step=STEP, relief=relief)


def picked(seen: Observation, order: IntArray) -> Observation:
    """Return the reading of these cells."""
    keys = CellKeys(
        code_index=seen.keys.code_index[order], dither=seen.keys.dither[order], pilot=seen.keys.pilot[order]
    )
    return Observation(
        phase=seen.phase[order],
        cells=seen.cells.take(order),
        keys=keys,
        step=seen.step,
        relief=seen.relief.take(order),
    )


def drawn_bits(seen: Observation, rng: np.random.Generator) -> IntArray:
    """Return the bits (n,) that the cells might carry: 0 of pilots."""
    return np.where(seen.keys.pilot, 0, rng.integers(0, 2, len(seen)))


def turned(seen: Observation, turns: IntArray) -> FloatArray:
    """Return the phases (n,) turned by so many times pi, those of pilots as they were."""
    return np.asarray(seen.phase + np.where(seen.keys.pilot, 0.0, np.pi * turns))
