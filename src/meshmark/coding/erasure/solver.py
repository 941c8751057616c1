"""Solving for the message symbols: elimination over bits, on the symbols that seem right."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.erasure.belief import trust
from meshmark.coding.erasure.graph import DENSE, Graph, mix
from meshmark.mesh import IntArray

__all__ = ["eliminate", "peel", "solve"]

SPARE = 24
"""Equations more than unknowns that are taken in the first place."""
# A solution is believed that this share of the symbols agree with.
AGREEING = 0.965
# So often the trust in each symbol is blurred, by so much, and the most trusted are taken again.
BLURRED, BLUR = 8, 3.0

# A table of this number of words at most takes less time as a whole than the rows of it that change.
SMALL = 3_000

Symbols = NDArray[np.uint16]
Words = NDArray[np.uint64]


def solve(graph: Graph, index: NDArray[np.uint32], value: Symbols, symbol_bits: int) -> Symbols | None:
    """Return the message symbols (size,), or None where a segment's symbols do not determine it.

    Some symbols may be wrong where there are more than needed.
    """
    segment = graph.segment(index)
    out = np.zeros((graph.segments, graph.length), np.uint16)
    order = np.argsort(segment, kind="stable")
    bounds = np.searchsorted(segment[order], np.arange(graph.segments + 1))
    if (np.diff(bounds) + graph.sparse + DENSE < graph.total).any():
        return None
    for number in range(graph.segments):
        rows = order[bounds[number] : bounds[number + 1]]
        found = _segment(graph, index[rows], value[rows], symbol_bits)
        if found is None:
            return None
        out[number] = found[: graph.length]
    return out.ravel()[: graph.size]


def _segment(graph: Graph, index: NDArray[np.uint32], value: Symbols, symbol_bits: int) -> Symbols | None:
    """Return the intermediate symbols that most agree with: peeled, of the first, else of those most trusted."""
    best, most = peel(graph, index, value), 0.0
    if best is not None and _agreeing(graph, best, index, value) >= AGREEING:
        return best
    best = _taken(graph, index, value, np.arange(len(index)))
    if best is not None:
        most = _agreeing(graph, best, index, value)
    if most >= AGREEING or len(index) < graph.length + 2:
        return best
    trusted = np.clip(trust(graph, index, value, symbol_bits), -BLUR, 3.0 * BLUR)
    for number in range(1 + BLURRED):
        blur = (mix(index, 9_500 + number) >> np.uint64(11)).astype(float) * 2.0**-53
        order = np.argsort(-trusted - BLUR * number * blur, kind="stable")
        found = _taken(graph, index, value, order)
        agreeing = 0.0 if found is None else _agreeing(graph, found, index, value)
        if agreeing > most:
            best, most = found, agreeing
        if most >= AGREEING:
            break
    return best


def _taken(graph: Graph, index: NDArray[np.uint32], value: Symbols, order: IntArray) -> Symbols | None:
    """Return the solution of as many symbols, in this order, as are likely to do; of all where they do not."""
    for take in (graph.length + SPARE, len(index)):
        rows = order[:take]
        found = eliminate(*_equations(graph, index[rows], value[rows]), graph.total)
        if found is not None or take >= len(index):
            return found
    return None


def _agreeing(graph: Graph, found: Symbols, index: NDArray[np.uint32], value: Symbols) -> float:
    row, symbol = graph.edges(index)
    decoded = np.bitwise_xor.reduceat(found[symbol], np.flatnonzero(np.diff(row, prepend=-1)))
    return float(np.mean(decoded == value))


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
        ready = np.unique(touched)
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
