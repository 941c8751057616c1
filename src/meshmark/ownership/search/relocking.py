"""What locking from clusters and locking anew share, whichever way the suspect is measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.grown_lock import grown
from meshmark.ownership.carriers.lattice import CellKeys
from meshmark.ownership.carriers.lock import LockSearch
from meshmark.ownership.carriers.quantisation import bit_phase, log10_lock_chance
from meshmark.ownership.parameters import CREDIBLE_LOG10, LOCK_EXPECTED, LOCK_RADIUS

__all__ = ["grown_locks", "relocked"]


def grown_locks(
    cells: Cells,
    keys: CellKeys,
    gradient: FloatArray,
    expected: FloatArray,
    steps: Sequence[float],
    orders: Sequence[IntArray],
    most: int,
) -> Iterator[tuple[float, FloatArray, float]]:
    """Yield (step, correction (d,), hypotheses tried) of each credible lock that grows from a cluster.

    gradient: (n, d) change of the offsets per unit of correction; expected, orders, most: as in `growing.grown`.
    """
    for step, order in product(steps, orders):
        psi = 2.0 * bit_phase(cells.offset, keys.dither, step)
        lock = grown(psi, 4.0 * np.pi / step * gradient, expected, order, most)
        if lock is None:
            continue
        tried = lock.tried * len(steps)
        if log10_lock_chance(lock.score, len(psi)) + np.log10(tried) < CREDIBLE_LOG10:
            yield step, lock.correction, tried


def relocked(
    cells: Cells, keys: CellKeys, gradient: FloatArray, step: float
) -> tuple[FloatArray, FloatArray, float]:
    """Return (phases (n,) after it, best correction (7,) close to where the cells were measured, tried)."""
    phase = bit_phase(cells.offset, keys.dither, step)
    search = LockSearch(2.0 * phase, 4.0 * np.pi / step * gradient, LOCK_EXPECTED, LOCK_RADIUS)
    correction = search.polished(search.rough(1))[0].correction
    return bit_phase(cells.offset + gradient @ correction, keys.dither, step), correction, search.tried
