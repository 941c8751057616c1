"""The word of a mark: its symbol and a MAC, as whole places in the three coordinates of its ring.

The MAC of a symbol is a universal hash, a * symbol + b modulo 2^64, of which the top bits are kept, with a and
b from BLAKE2b of the key, the model's id and the ring: a pair that is used once (Dietzfelbinger 1996,
doi:10.1007/3-540-60922-9_46). An attacker who sees a word cannot make one for another symbol, ring or model.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import AnyIntArray
from meshmark.authentication.marks.candidates import HEADER, Candidates
from meshmark.authentication.parameters import Layout
from meshmark.coding.keyed import cell_words
from meshmark.coding.keys import Key
from meshmark.mesh import FloatArray, IntArray

__all__ = ["PURPOSE", "bind", "places_of", "symbols_at", "words_of"]

PURPOSE = "authentication marks"
_BOUND = "authentication marks of one model"


def bind(found: Candidates, key: Key, nonce: int | NDArray[np.uint64] | None) -> NDArray[np.uint64]:
    """Return (c, 3): factor, summand and mask of each candidate; those of headers do not depend on the nonce.

    nonce: of all, or (c,) of each. Without one the others are meaningless.
    """
    bound = found.words[:, :3].copy()
    rows = np.flatnonzero(found.kind != HEADER)
    if nonce is not None and len(rows):
        ring = np.column_stack([found.name[rows], found.words[rows, :2]]).view(np.int64)
        model = np.broadcast_to(np.asarray(nonce, np.uint64), len(bound))[rows, None].view(np.int64)
        bound[rows] = cell_words(key.subkey(_BOUND), np.concatenate([model, ring], axis=1), 3)
    return bound


def words_of(
    symbols: IntArray, boundary: AnyIntArray, bound: NDArray[np.uint64], layout: Layout
) -> NDArray[np.uint64]:
    """Return the masked words (c,) of symbols (c,) in rings of which `boundary` (c,) is on a boundary."""
    symbol = symbols.astype(np.uint64)
    word = (symbol << np.uint64(layout.check)) | _mac(symbol, boundary, bound, layout)
    return word ^ _mask(bound, layout)


def places_of(words: NDArray[np.uint64], place: FloatArray, layout: Layout) -> IntArray:
    """Return (c, 3): the whole places nearest to `place` (c, 3) that say these words."""
    radix = np.array(layout.radix)
    digits = words.astype(np.int64)[:, None] // _weights(layout) % radix
    return np.asarray(digits + radix * np.round((place - digits) / radix).astype(np.int64))


def symbols_at(
    places: IntArray, boundary: AnyIntArray, bound: NDArray[np.uint64], layout: Layout
) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return the symbols (c,) that whole places (c, 3) say, and whether their MAC holds."""
    word = places % np.array(layout.radix) @ _weights(layout)
    inside = word < 1 << layout.bits
    plain = np.where(inside, word, 0).astype(np.uint64) ^ _mask(bound, layout)
    symbol = plain >> np.uint64(layout.check)
    holds = plain & np.uint64((1 << layout.check) - 1) == _mac(symbol, boundary, bound, layout)
    return symbol.astype(np.int64), inside & holds


def _mac(
    symbol: NDArray[np.uint64], boundary: AnyIntArray, bound: NDArray[np.uint64], layout: Layout
) -> NDArray[np.uint64]:
    text = symbol | boundary.astype(np.uint64) << np.uint64(16)
    mixed = bound[:, 0] * (text + np.uint64(1)) + bound[:, 1]
    return np.asarray(mixed, np.uint64) >> np.uint64(64 - layout.check)


def _weights(layout: Layout) -> IntArray:
    return np.cumprod([1, *layout.radix[:2]])


def _mask(bound: NDArray[np.uint64], layout: Layout) -> NDArray[np.uint64]:
    return bound[:, 2] & np.uint64((1 << layout.bits) - 1)
