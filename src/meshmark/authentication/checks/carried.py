"""The payload symbols that marks carry, and what they are once it is known where the model lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import AnyIntArray
from meshmark.authentication.checks.model_frame import ModelFrame, evidence_of
from meshmark.authentication.marks.candidates import Candidates
from meshmark.authentication.marks.model_cells import masks, near_cells
from meshmark.authentication.payload.payload import SymbolSource
from meshmark.coding.keys import Key
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Carried", "Expected", "Reading", "carried"]

# A mark may lie in any cell within this number of deviations of the fit, and errors of its centre.
_DOUBTS, _BLURS = 4.0, 2.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Carried:
    """k marks that carry payload.

    index, value: (k,) of the symbols, as the marks say them. vertex: (k,) points. ring: (k,) the first keyed word
    of each ring; centre: (k, 3) of the ring in the suspect. plain: (k,) whether its ring was read in one way alone,
    so that it is hardly there by chance.
    """

    index: NDArray[np.uint32]
    value: NDArray[np.uint16]
    vertex: AnyIntArray
    ring: NDArray[np.uint64]
    centre: FloatArray
    plain: NDArray[np.bool_]

    def take(self, rows: NDArray[np.bool_]) -> Carried:
        """Return these marks."""
        return Carried(
            index=self.index[rows],
            value=self.value[rows],
            vertex=self.vertex[rows],
            ring=self.ring[rows],
            centre=self.centre[rows],
            plain=self.plain[rows],
        )


def carried(found: Candidates, symbol: IntArray, plain: NDArray[np.bool_] | None = None) -> Carried:
    """Return what candidates that hold carry, as symbols (c,); plain: (c,) of `Carried`, all where it is None."""
    return Carried(
        index=found.index,
        value=symbol.astype(np.uint16),
        vertex=found.vertex,
        ring=found.name,
        centre=found.centre,
        plain=np.ones(len(symbol), bool) if plain is None else plain,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class Reading:
    """How symbols are read: by the cells of the marked model, or (without a frame) as the marks say them."""

    key: Key
    nonce: int
    symbol_bits: int
    frame: ModelFrame | None

    def values(self, marks: Carried) -> tuple[IntArray, IntArray]:
        """Return which mark each value is of, and the values (j,): one for each cell that a mark may lie in."""
        if self.frame is None or not len(marks.index):
            return np.arange(len(marks.index)), marks.value.astype(np.int64)
        row, cells = near_cells(self.frame(marks.centre), self._doubt(marks.centre), self.symbol_bits)
        mask = masks(self.key, self.nonce, self.symbol_bits)(marks.ring[row], cells)
        return row, marks.value[row].astype(np.int64) ^ mask

    def sure(self, marks: Carried) -> tuple[NDArray[np.uint32], NDArray[np.uint16]]:
        """Return indices and values of the marks whose cell is known."""
        row, value = self.values(marks)
        single = np.bincount(row, minlength=len(marks.index)) == 1
        chosen = single[row]
        return marks.index[row[chosen]], value[chosen].astype(np.uint16)

    def _doubt(self, centre: FloatArray) -> FloatArray:
        if self.frame is None:
            return np.zeros(len(centre))
        along = [self.frame.doubt(centre, np.tile(axis, (len(centre), 1))) for axis in np.eye(3)]
        return np.asarray(_DOUBTS * np.max(along, axis=0) + _BLURS * self.frame.blur)


@dataclass(frozen=True, eq=False, kw_only=True)
class Expected:
    """What a model that was marked says where it is intact.

    source: the payload's symbols by index. reading: how they are read. frame: where the model lies, which small
    models tell, too, whose symbols are read without; None where that is not known. once: no two of its marks that
    tell the id have rings that are alike.
    """

    source: SymbolSource
    reading: Reading
    frame: ModelFrame | None
    once: bool

    def agrees(self, marks: Carried) -> NDArray[np.bool_]:
        """Return (k,): which marks say the payload's symbol in a cell where they may lie."""
        row, value = self.reading.values(marks)
        right = np.zeros(len(marks.index), bool)
        right[row[value == self.source(marks.index)[row]]] = True
        return right

    def in_place(self, found: Candidates, symbol: IntArray) -> NDArray[np.bool_]:
        """Return (c,): which marks that carry their place, as symbols (c,), lie there; all if it is not known."""
        if self.frame is None or not len(symbol):
            return np.ones(len(symbol), bool)
        return ~self.frame.far(evidence_of(found, symbol, self.reading.symbol_bits, self.frame.error))
