"""The symbols that are not the payload's: pieces of the model's id, and places."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import Candidates
from meshmark.coding.keyed import unit_interval
from meshmark.mesh import FloatArray, IntArray

__all__ = ["covers_id", "directions", "header_symbols", "place_symbols", "place_values", "read_header"]

ID_BITS = 64


def header_symbols(index: NDArray[np.uint32], nonce: int, symbol_bits: int) -> IntArray:
    """Return for each index (c,) the piece of the 64-bit id that it carries."""
    width = _width(symbol_bits)
    piece = index.astype(np.int64) % (ID_BITS // width)
    pieces = np.array([nonce >> shift & (1 << width) - 1 for shift in range(0, ID_BITS, width)])
    return np.asarray(pieces[piece])


def read_header(index: NDArray[np.uint32], symbols: IntArray, symbol_bits: int) -> int | None:
    """Return the id that most symbols (c,) of each piece report, None where a piece has none."""
    width = _width(symbol_bits)
    piece = index.astype(np.int64) % (ID_BITS // width)
    votes = np.zeros((ID_BITS // width, 1 << width), np.int64)
    in_range = symbols < 1 << width
    np.add.at(votes, (piece[in_range], symbols[in_range]), 1)
    if not votes.any(axis=1).all():
        return None
    return sum(int(value) << width * place for place, value in enumerate(votes.argmax(axis=1)))


def covers_id(index: NDArray[np.uint32], symbol_bits: int) -> bool:
    """Return whether each piece of the id has an index (c,) that carries it."""
    count = ID_BITS // _width(symbol_bits)
    return len(np.unique(index.astype(np.int64) % count)) == count


def place_symbols(found: Candidates, frame: tuple[FloatArray, float], symbol_bits: int) -> IntArray:
    """Return where rings lie along a keyed direction of each, (c,), in a frame of middle and radius."""
    middle, radius = frame
    along = np.einsum("ri,ri->r", (found.centre - middle) / radius, directions(found))
    whole = np.floor((along + 1.0) / 2.0 * (1 << symbol_bits)).astype(np.int64)
    return np.asarray(np.clip(whole, 0, (1 << symbol_bits) - 1))


def place_values(symbols: IntArray, symbol_bits: int) -> FloatArray:
    """Return the middle (c,) of what each symbol of `place_symbols` says, -1 to 1."""
    return np.asarray((symbols + 0.5) * 2.0 / (1 << symbol_bits) - 1.0)


def directions(found: Candidates) -> FloatArray:
    """Return (c, 3) keyed unit vectors."""
    word = found.words[:, 6]
    vectors = np.stack([unit_interval(word << np.uint64(21 * axis)) for axis in range(3)], axis=1) - 0.5
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-9)[:, None])


def _width(symbol_bits: int) -> int:
    return 8 if symbol_bits >= 8 else 4
