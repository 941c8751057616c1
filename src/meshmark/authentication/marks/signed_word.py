"""What the marks of a small model tell between them: a keyed word of its id and of how many points it had.

They have no room for either. A reader who knows the id computes the word for each number of points, and takes the
one that the marks agree with.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.symbols import header_symbols, pieces_of_id
from meshmark.coding.keyed import cell_words
from meshmark.coding.keys import Key
from meshmark.mesh import IntArray

__all__ = ["signed_points", "signed_word"]

_PURPOSE = "authentication marks of small models"
# Most points that are looked for; small models have fewer.
_MOST = 5000
# Share of the marks that must agree, and how many pieces at least: five of 4 bits agree by chance in one of 2^20.
_AGREE, _PIECES = 0.7, 5


def signed_word(key: Key, identity: int, points: int) -> int:
    """Return the 64-bit word of an id and a number of points, 0 where points are not counted."""
    return int(_words(key, identity, np.array([points]))[0])


def signed_points(
    index: NDArray[np.uint32], symbol: IntArray, symbol_bits: int, key: Key, identity: int, *, now: int
) -> int | None:
    """Return the number of points that the marks were made for, None where they agree with none.

    index, symbol: (c,) of the marks whose MAC holds; now: points that there are, which is tried first.
    """
    if not len(index):
        return None
    others = np.arange(1, _MOST + 1)
    counts = np.concatenate([[now, 0], others[np.argsort(np.abs(others - now), kind="stable")]])
    words = _words(key, identity, counts)
    piece = index % pieces_of_id(symbol_bits)
    least = min(_PIECES, len(np.unique(piece)))
    for count, word in zip(counts.tolist(), words.tolist(), strict=True):
        agrees = header_symbols(index, word, symbol_bits) == symbol
        if agrees.mean() >= _AGREE and len(np.unique(piece[agrees])) >= least:
            return int(count)
    return None


def _words(key: Key, identity: int, points: IntArray) -> NDArray[np.uint64]:
    model = np.full(len(points), identity, np.uint64).view(np.int64)
    return cell_words(key.subkey(_PURPOSE), np.stack([model, points.astype(np.int64)], axis=1), 1)[:, 0]
