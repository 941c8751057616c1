"""What binds a payload symbol to its place in the model: a keyed mask that differs from cell to cell.

The MAC of a mark depends on its ring alone, which reads the same wherever it lies: it must hold before anyone knows
where the model is. But the symbol under it is masked by a keyed hash of ring and cell, a cube of the marked
model. Once the marks that carry their place have told where the model lies, the symbol of a mark that was copied to
another cell comes out wrong, and the payload knows what it should be.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.keyed import cell_words
from meshmark.coding.keys import Key
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Masks", "cells_of", "masks", "near_cells"]

_PURPOSE: Final = "authentication marks in their cells"
# Side of a cell in half diagonals, and in steps of the places that marks carry coarsely.
_SIDE, _STEPS = 1.0 / 16.0, 2.0

Masks = Callable[[NDArray[np.uint64], IntArray], IntArray]
"""Of rings (c,), their first keyed words, in cells (c, 3)."""


def cells_of(places: FloatArray, symbol_bits: int) -> IntArray:
    """Return the cells (c, 3) of places (c, 3), in half diagonals from the middle of the marked model."""
    return np.floor(places / _side(symbol_bits)).astype(np.int64)


def near_cells(places: FloatArray, doubt: FloatArray, symbol_bits: int) -> tuple[IntArray, IntArray]:
    """Return all cells (k, 3) within `doubt` (c,) of places (c, 3), and which place each is of (k,), in order.

    The cell of a place itself comes first among its cells.
    """
    side = _side(symbol_bits)
    cells = cells_of(places, symbol_bits)
    low = np.floor((places - doubt[:, None]) / side).astype(np.int64)
    high = np.floor((places + doubt[:, None]) / side).astype(np.int64)
    other = np.where(low < cells, -1, np.where(high > cells, 1, 0))
    rows, found = [np.arange(len(cells))], [cells]
    for axes in list(product((0, 1), repeat=3))[1:]:
        chosen = np.array(axes)
        row = np.flatnonzero((other[:, chosen == 1] != 0).all(axis=1))
        rows.append(row)
        found.append(cells[row] + other[row] * chosen)
    row = np.concatenate(rows)
    order = np.argsort(row, kind="stable")
    return row[order], np.concatenate(found)[order]


def masks(key: Key, nonce: int, symbol_bits: int) -> Masks:
    """Return what gives the masks of a model with this 64-bit id."""
    subkey, most = key.subkey(_PURPOSE), np.uint64((1 << symbol_bits) - 1)

    def of(ring: NDArray[np.uint64], cells: IntArray) -> IntArray:
        model = np.full((len(ring), 1), nonce, np.uint64).view(np.int64)
        named = np.concatenate([model, ring.view(np.int64)[:, None], cells], axis=1)
        return np.asarray((cell_words(subkey, named, 1)[:, 0] & most).astype(np.int64))

    return of


def _side(symbol_bits: int) -> float:
    return max(_SIDE, _STEPS * 2.0 / (1 << symbol_bits))
