"""The symbols that are not the payload's: pieces of the model's id, and places."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import Candidates
from meshmark.authentication.parameters import TRIED_IDS
from meshmark.coding.keyed import unit_interval
from meshmark.mesh import FloatArray, IntArray

__all__ = [
    "covers_id",
    "directions",
    "fine_period",
    "header_symbols",
    "ids_of_votes",
    "is_fine",
    "outvoted",
    "pieces_of_id",
    "place_symbols",
    "place_values",
    "read_header",
]

ID_BITS = 64
# Ids up to which second values of pieces are taken.
_DOUBTED = 512
# The period of fine places is the extent over 2 to this: a shift that coarse ones can tell, and more steps finer.
_PERIOD_BITS = 6


def header_symbols(index: NDArray[np.uint32], nonce: int, symbol_bits: int) -> IntArray:
    """Return for each index (c,) the piece of the 64-bit id that it carries."""
    width = _width(symbol_bits)
    piece = index.astype(np.int64) % (ID_BITS // width)
    pieces = np.array([nonce >> shift & (1 << width) - 1 for shift in range(0, ID_BITS, width)])
    return np.asarray(pieces[piece])


def read_header(
    index: NDArray[np.uint32], symbols: IntArray, weight: FloatArray, symbol_bits: int
) -> list[int]:
    """Return the ids that symbols (c,) report, the likeliest first: for each piece that with the most weight (c,).

    Of the two pieces that are least sure others are taken, too, in all combinations, `TRIED_IDS` at most. Empty
    where more pieces have no symbol.
    """
    width = _width(symbol_bits)
    votes = _votes(index, symbols, weight, width)
    if (~votes.any(axis=1)).sum() > 1:
        return []
    order = np.argsort(-votes, axis=1, kind="stable")
    ranked = np.take_along_axis(votes, order, axis=1)
    weak, second = np.argsort(ranked[:, 0] - ranked[:, 1] + ranked[:, 0], kind="stable")[:2]
    found = []
    for other, value in product(order[second, :2], order[weak, : TRIED_IDS // 2]):
        chosen = order[:, 0].copy()
        chosen[weak], chosen[second] = value, other
        found.append(sum(int(each) << width * place for place, each in enumerate(chosen)))
    return found


def ids_of_votes(
    index: NDArray[np.uint32], symbols: IntArray, weight: FloatArray, symbol_bits: int, most: int
) -> NDArray[np.uint64]:
    """Return the ids (k,) that symbols (c,) may report: for each piece the value with the most weight (c,).

    For pieces without a symbol all values, in all combinations; empty where these are more than `most`. While ids
    are fewer than `_DOUBTED`, the second value is taken, too, of the pieces that are least sure.
    """
    width = _width(symbol_bits)
    votes = _votes(index, symbols, weight, width)
    order = np.asarray(np.argsort(-votes, axis=1, kind="stable"), np.uint64)
    ranked = -np.sort(-votes, axis=1)
    voted = [bool(row.any()) for row in votes]
    if (1 << width) ** voted.count(False) > most:
        return np.empty(0, np.uint64)
    choices = [order[piece, : 1 if voted[piece] else None] for piece in range(len(votes))]
    for piece in np.argsort(2.0 * ranked[:, 0] - ranked[:, 1], kind="stable"):
        if voted[piece] and 2 * np.prod([float(len(each)) for each in choices]) <= min(_DOUBTED, most):
            choices[piece] = order[piece, :2]
    ids = np.zeros(1, np.uint64)
    for place, values in enumerate(choices):
        ids = (ids[:, None] | values << np.uint64(width * place)).ravel()
    return ids


def _votes(index: NDArray[np.uint32], symbols: IntArray, weight: FloatArray, width: int) -> FloatArray:
    """Return (pieces, values): the weight (c,) of the symbols that say each value of each piece."""
    count = ID_BITS // width
    votes = np.zeros((count, 1 << width))
    in_range = symbols < 1 << width
    piece = index.astype(np.int64) % count
    np.add.at(votes, (piece[in_range], symbols[in_range]), weight[in_range])
    return votes


def outvoted(
    index: NDArray[np.uint32], symbols: IntArray, symbol_bits: int, voting: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return (c,): which symbols (c,) are not what most of the `voting` (c,) say of the same piece of the id."""
    votes = _votes(index, symbols, voting.astype(np.float64), _width(symbol_bits))
    piece = index.astype(np.int64) % len(votes)
    return np.asarray(votes[piece, symbols] < votes[piece].max(axis=1))


def covers_id(index: NDArray[np.uint32], symbol_bits: int) -> bool:
    """Return whether each piece of the id has an index (c,) that carries it."""
    count = pieces_of_id(symbol_bits)
    return len(np.unique(index.astype(np.int64) % count)) == count


def pieces_of_id(symbol_bits: int) -> int:
    """Return how many pieces the id is carried in."""
    return ID_BITS // _width(symbol_bits)


def is_fine(index: NDArray[np.uint32]) -> NDArray[np.bool_]:
    """Return which places (c,) are told finely, modulo `fine_period`."""
    return np.asarray(index % 2 == 1)


def fine_period(symbol_bits: int) -> float:
    """Return the period of fine places, in half diagonals: some steps of the coarse ones."""
    return float(2.0 ** (1 - min(_PERIOD_BITS, symbol_bits - 2)))


def place_symbols(found: Candidates, frame: tuple[FloatArray, float], symbol_bits: int) -> IntArray:
    """Return where rings lie along a keyed direction of each, (c,), in a frame of middle and radius."""
    middle, radius = frame
    along = np.einsum("ri,ri->r", (found.centre - middle) / radius, directions(found))
    period = np.where(is_fine(found.index), fine_period(symbol_bits), 2.0)
    share = (along + 1.0) / period
    share = np.where(is_fine(found.index), share - np.floor(share), share)
    return np.asarray(
        np.clip(np.floor(share * (1 << symbol_bits)), 0, (1 << symbol_bits) - 1).astype(np.int64)
    )


def place_values(
    symbols: IntArray, fine: NDArray[np.bool_], symbol_bits: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the middle (c,) of what each symbol of `place_symbols` says, from -1; its step, and its period.

    Both in half diagonals; the period is infinite of coarse places, which are not `fine` (c,).
    """
    span = np.where(fine, fine_period(symbol_bits), 2.0)
    step = span / (1 << symbol_bits)
    return (symbols + 0.5) * step - 1.0, step, np.where(fine, span, np.inf)


def directions(found: Candidates) -> FloatArray:
    """Return (c, 3) keyed unit vectors."""
    word = found.words[:, 3]
    vectors = np.stack([unit_interval(word << np.uint64(21 * axis)) for axis in range(3)], axis=1) - 0.5
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-9)[:, None])


def _width(symbol_bits: int) -> int:
    return 8 if symbol_bits >= 8 else 4
