"""Solving for the message symbols: elimination over bits, on the symbols that seem right."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.erasure_graph import DENSE, Graph

__all__ = ["eliminate", "solve"]

SPARE = 24
"""Equations more than unknowns that are taken in the first place."""

Symbols = NDArray[np.uint16]
Words = NDArray[np.uint64]


def solve(graph: Graph, index: NDArray[np.uint32], value: Symbols) -> Symbols | None:
    """Return the message symbols (size,), or None where a segment's symbols do not determine it."""
    segment = graph.segment(index)
    out = np.zeros((graph.segments, graph.length), np.uint16)
    order = np.argsort(segment, kind="stable")
    bounds = np.searchsorted(segment[order], np.arange(graph.segments + 1))
    for number in range(graph.segments):
        rows = order[bounds[number] : bounds[number + 1]]
        found = _segment(graph, index[rows], value[rows])
        if found is None:
            return None
        out[number] = found[: graph.length]
    return out.ravel()[: graph.size]


def _segment(graph: Graph, index: NDArray[np.uint32], value: Symbols) -> Symbols | None:
    if len(index) + graph.sparse + DENSE < graph.total:
        return None
    take = graph.length + SPARE
    found = eliminate(*_equations(graph, index[:take], value[:take]), graph.total)
    if found is None and take < len(index):
        found = eliminate(*_equations(graph, index, value), graph.total)
    return found


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


def eliminate(rows: Words, right: Symbols, unknowns: int) -> Symbols | None:
    """Return the unknowns (unknowns,) by Gauss-Jordan elimination, None where they are not determined."""
    rows, right = rows.copy(), right.copy()
    for column in range(unknowns):
        word, bit = divmod(column, 64)
        has = (rows[:, word] >> np.uint64(bit)) & np.uint64(1) != 0
        first = column + int(np.argmax(has[column:])) if column < len(rows) else -1
        if first < 0 or not has[first]:
            return None
        if first != column:
            rows[[column, first]] = rows[[first, column]]
            right[[column, first]] = right[[first, column]]
            has[first] = has[column]
        has[column] = False
        hit = np.flatnonzero(has)
        rows[hit, word:] ^= rows[column, word:]
        right[hit] ^= right[column]
    return right[:unknowns]
