"""Solving for the message symbols: elimination over bits, on the symbols that seem right."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import sorted_distinct
from meshmark.coding.erasure.belief import trust
from meshmark.coding.erasure.graph import DENSE, Graph, mix
from meshmark.mesh import IntArray

__all__ = ["ENOUGH", "eliminate", "peel", "solve"]

SPARE = 24
"""Equations more than unknowns that are taken in the first place."""
ENOUGH = 0.965
"""A solution is taken at first that this share of the symbols agree with."""
# Unknowns of a solution that are changed at most so that more symbols agree.
CHANGES = 64
# So often the trust in each symbol is blurred, by so much, and the most trusted are taken again.
BLURRED, BLUR = 8, 3.0

# A table of this number of words at most takes less time as a whole than the rows of it that change.
SMALL = 3_000

Symbols = NDArray[np.uint16]
Words = NDArray[np.uint64]


def solve(
    graph: Graph, index: NDArray[np.uint32], value: Symbols, symbol_bits: int, enough: float = ENOUGH
) -> Symbols | None:
    """Return the message symbols (size,), or None where a segment's symbols do not determine it.

    Some symbols may be wrong where there are more than needed. enough: share of the symbols that agree with a
    solution for which no other is looked for.
    """
    segment = graph.segment(index)
    out = np.zeros((graph.segments, graph.length), np.uint16)
    order = np.argsort(segment, kind="stable")
    bounds = np.searchsorted(segment[order], np.arange(graph.segments + 1))
    if (np.diff(bounds) + graph.sparse + DENSE < graph.total).any():
        return None
    for number in range(graph.segments):
        rows = order[bounds[number] : bounds[number + 1]]
        found = _segment(graph, index[rows], value[rows], symbol_bits, enough)
        if found is None:
            return None
        out[number] = found[: graph.length]
    return out.ravel()[: graph.size]


def _segment(
    graph: Graph, index: NDArray[np.uint32], value: Symbols, symbol_bits: int, enough: float
) -> Symbols | None:
    """Return the intermediate symbols that most agree with: peeled, of the first, else of those most trusted."""
    best, most = _refined(graph, index, value, peel(graph, index, value))
    if most >= enough:
        return best
    found = _refined(graph, index, value, _taken(graph, index, value, np.arange(len(index))))
    best, most = max((best, most), found, key=lambda each: each[1])
    if most >= enough or len(index) < graph.length + 2:
        return best
    trusted = np.clip(trust(graph, index, value, symbol_bits), -BLUR, 3.0 * BLUR)
    for number in range(1 + BLURRED):
        blur = (mix(index, 9_500 + number) >> np.uint64(11)).astype(float) * 2.0**-53
        order = np.argsort(-trusted - BLUR * number * blur, kind="stable")
        found = _refined(graph, index, value, _taken(graph, index, value, order))
        best, most = max((best, most), found, key=lambda each: each[1])
        if most >= enough:
            break
    return best


def _refined(
    graph: Graph, index: NDArray[np.uint32], value: Symbols, found: Symbols | None
) -> tuple[Symbols | None, float]:
    """Return a solution, or one near it that more of the symbols agree with, and the share of them that do.

    A wrong symbol that a solution was made of agrees with it, and puts a few unknowns wrong: then most of the
    others that name one of them are off by the same. As long as it makes more agree than disagree, an unknown is
    changed so.
    """
    if found is None:
        return None, 0.0
    row, symbol = graph.edges(index)
    # An unknown that a single symbol names is held by its parities alone.
    parity, tied = graph.sparse_rows
    order = np.argsort(parity, kind="stable")
    row, symbol = np.concatenate([row, len(index) + parity[order]]), np.concatenate([symbol, tied[order]])
    first = np.flatnonzero(np.diff(row, prepend=-1))
    right = np.concatenate([value, np.zeros(graph.sparse, np.uint16)])
    off = np.bitwise_xor.reduceat(found[symbol], first) ^ right
    for _ in range(CHANGES):
        wrong = off != 0
        if not wrong.any() or wrong.mean() > 0.5:
            break
        edge = wrong[row]
        pairs, times = np.unique(symbol[edge] << 16 | off[row[edge]].astype(np.int64), return_counts=True)
        unknown, change = pairs >> 16, (pairs & 0xFFFF).astype(np.uint16)
        gain = times - np.bincount(symbol[~edge], minlength=graph.total)[unknown]
        best = int(gain.argmax())
        if gain[best] <= 0:
            break
        found = found.copy()
        found[unknown[best]] ^= change[best]
        off = np.bitwise_xor.reduceat(found[symbol], first) ^ right
    return found, float(np.mean(off[: len(index)] == 0))


def _taken(graph: Graph, index: NDArray[np.uint32], value: Symbols, order: IntArray) -> Symbols | None:
    """Return the solution of as many symbols, in this order, as are likely to do; of all where they do not."""
    for take in (graph.length + SPARE, len(index)):
        rows = order[:take]
        found = eliminate(*_equations(graph, index[rows], value[rows]), graph.total)
        if found is not None or take >= len(index):
            return found
    return None


def _equations(graph: Graph, index: NDArray[np.uint32], value: Symbols) -> tuple[Words, Symbols]:
    """Return the equations of parities and symbols: bits packed into words (r, w), right sides (r,)."""
    parities = graph.sparse + DENSE
    dense = np.zeros((parities + len(index), -(-graph.total // 64) * 64), np.uint8)
    np.bitwise_xor.at(dense, graph.sparse_rows, 1)
    dense[graph.sparse : parities, : graph.total] = graph.dense_rows
    row, symbol = graph.edges(index)
    np.bitwise_xor.at(dense, (parities + row, symbol), 1)
    packed = np.packbits(dense, axis=1, bitorder="little").view("<u8").astype(np.uint64)
    return packed, np.concatenate([np.zeros(parities, np.uint16), value])


def peel(graph: Graph, index: NDArray[np.uint32], value: Symbols) -> Symbols | None:
    """Return the intermediate symbols (total,) where one equation after another has one unknown left, else None.

    That takes more symbols than elimination does, but far less time.
    """
    row, symbol = graph.edges(index)
    parity, member = graph.sparse_rows
    pair = np.concatenate([row * graph.total + symbol, (len(index) + parity) * graph.total + member])
    pair, times = np.unique(pair, return_counts=True)
    row, symbol = np.divmod(pair[times % 2 == 1], graph.total)
    right = np.concatenate([value, np.zeros(graph.sparse, np.uint16)])
    degree = np.bincount(row, minlength=len(right))
    left = np.zeros(len(right), np.int64)
    np.bitwise_xor.at(left, row, symbol)
    order = np.argsort(symbol, kind="stable")
    row, symbol = row[order], symbol[order]
    start = np.searchsorted(symbol, np.arange(graph.total + 1))
    found, known = np.zeros(graph.total, np.uint16), np.zeros(graph.total, bool)
    ready = np.flatnonzero(degree == 1)
    while len(ready):
        new, first = np.unique(left[ready], return_index=True)
        found[new], known[new] = right[ready[first]], True
        length = start[new + 1] - start[new]
        edge = np.repeat(start[new] - np.cumsum(length) + length, length) + np.arange(length.sum())
        touched = row[edge]
        np.subtract.at(degree, touched, 1)
        np.bitwise_xor.at(left, touched, symbol[edge])
        np.bitwise_xor.at(right, touched, found[symbol[edge]])
        ready = sorted_distinct(touched)
        ready = ready[degree[ready] == 1]
    return graph.with_parities(found[None])[0] if known[: graph.length].all() else None


def eliminate(rows: Words, right: Symbols, unknowns: int) -> Symbols | None:
    """Return the unknowns (unknowns,) by Gauss-Jordan elimination, None where they are not determined."""
    table = np.column_stack([rows, right.astype(np.uint64)])
    for column in range(unknowns):
        word, bit = divmod(column, 64)
        has = (table[:, word] >> np.uint64(bit)) & np.uint64(1)
        first = column + int(has[column:].argmax()) if column < len(table) else -1
        if first < 0 or not has[first]:
            return None
        if first != column:
            table[[column, first]] = table[[first, column]]
            has[first] = has[column]
        has[column] = 0
        if table.size <= SMALL:
            table ^= has[:, None] * table[column]
        else:
            table[np.flatnonzero(has)] ^= table[column]
    return table[:unknowns, -1].astype(np.uint16)
