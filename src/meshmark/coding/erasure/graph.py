"""The graph of the erasure code: which intermediate symbols each index and each parity adds up."""

from __future__ import annotations

from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import IntArray

__all__ = ["DENSE", "Graph", "mix", "sizes"]

SEGMENT = 1024
"""Most message symbols of a segment."""
# Sizes of messages: every number at first, then this factor apart.
SMALLEST, LARGEST, GROWTH = 8, 1 << 18, 1.02
# Sparse parities: SPARSE more than SPARSE_SHARE of the message symbols; each symbol is in SPARSE_DEGREE of them.
# DENSE parities are dense.
SPARSE_SHARE, SPARSE, SPARSE_DEGREE = 0.01, 4, 3
DENSE = 10
# Degrees of the symbols (Shokrollahi's distribution, without its rarest degree), and their shares.
DEGREES = np.array([1, 2, 3, 4, 5, 8, 9, 19, 65])
SHARES = np.array([0.03, 0.472, 0.166, 0.073, 0.083, 0.056, 0.037, 0.056, 0.027])
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)

Symbols = NDArray[np.uint16]


def mix(index: NDArray[np.uint32], stream: int | NDArray[np.int64]) -> NDArray[np.uint64]:
    """Return pseudo-random 64-bit words of the indices, broadcast with the stream's numbers (splitmix64)."""
    word = np.asarray(index, np.uint64) + (np.asarray(stream).astype(np.uint64) << np.uint64(32))
    word = (word + np.uint64(1)) * _GOLDEN
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(word ^ (word >> np.uint64(31)))


@cache
def sizes() -> IntArray:
    """Return the sizes that a message can have, in symbols, rising."""
    out = [SMALLEST]
    while out[-1] < LARGEST:
        out.append(max(out[-1] + 1, int(out[-1] * GROWTH)))
    return np.array(out)


class Graph:
    """The graph for messages of `size` symbols, in segments of equal length (the last may be shorter of use).

    length: message symbols of a segment; total: with its parities. Message symbol i is number i % length of
    segment i // length.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.segments = int(self.segments_of(np.array(size)))
        self.length = -(-size // self.segments)
        self.sparse = int(SPARSE_SHARE * self.length) + SPARSE
        self.total = self.length + self.sparse + DENSE

    @staticmethod
    def segments_of(size: IntArray) -> IntArray:
        """Return the number of segments of messages of these sizes."""
        return np.asarray(-(-size // SEGMENT))

    @cached_property
    def sparse_rows(self) -> tuple[IntArray, IntArray]:
        """Parity and symbol numbers of the sparse parities' edges, the parities' own symbols included."""
        symbol = np.repeat(np.arange(self.length), SPARSE_DEGREE)
        words = mix(symbol.astype(np.uint32), 7_000 + np.tile(np.arange(SPARSE_DEGREE), self.length))
        parity = (words % np.uint64(self.sparse)).astype(np.int64)
        own = np.arange(self.sparse)
        return np.concatenate([parity, own]), np.concatenate([symbol, self.length + own])

    @cached_property
    def dense_rows(self) -> NDArray[np.bool_]:
        """(DENSE, total): which symbols each dense parity adds up, its own included."""
        inner = self.length + self.sparse
        words = mix(np.arange(inner, dtype=np.uint32), 8_000 + np.arange(DENSE)[:, None])
        return np.concatenate([(words >> np.uint64(63)) == 1, np.eye(DENSE, dtype=bool)], axis=1)

    def intermediate(self, message: Symbols) -> Symbols:
        """Return (segments, total): the message (size,) with its parities."""
        out = np.zeros((self.segments, self.total), np.uint16)
        padded = np.zeros(self.segments * self.length, np.uint16)
        padded[: self.size] = message
        out[:, : self.length] = padded.reshape(self.segments, self.length)
        return self.with_parities(out)

    def with_parities(self, symbols: Symbols) -> Symbols:
        """Return (n, total) intermediate symbols with their parities as the message symbols among them have it."""
        out = symbols.copy()
        out[:, self.length :] = 0
        parity, symbol = self.sparse_rows
        inner = symbol < self.length
        for row in out:
            np.bitwise_xor.at(row, self.length + parity[inner], row[symbol[inner]])
        reach = self.length + self.sparse
        for number, chosen in enumerate(self.dense_rows):
            out[:, reach + number] = np.bitwise_xor.reduce(out[:, :reach][:, chosen[:reach]], axis=1)
        return out

    def segment(self, index: NDArray[np.uint32]) -> IntArray:
        """Return (n,): the segment of each index."""
        return np.asarray(mix(index, 9_000) % np.uint64(self.segments)).astype(np.int64)

    def edges(self, index: NDArray[np.uint32]) -> tuple[IntArray, IntArray]:
        """Return row numbers, rising, and symbol numbers within the segment of all edges of the indices."""
        draw = (mix(index, 9_001) >> np.uint64(11)).astype(np.float64) * 2.0**-53
        number = np.minimum(np.searchsorted(np.cumsum(SHARES), draw, side="right"), len(DEGREES) - 1)
        degree = np.minimum(DEGREES[number], self.total)
        row = np.repeat(np.arange(len(index)), degree)
        place = np.arange(len(row)) - np.repeat(np.cumsum(degree) - degree, degree)
        symbol = mix(index[row], 9_003 + place) % np.uint64(self.total)
        return row, np.asarray(symbol, np.int64)

    def outputs(self, intermediate: Symbols, index: NDArray[np.uint32]) -> Symbols:
        """Return (n,): the symbols of the indices."""
        if not len(index):
            return np.zeros(0, np.uint16)
        row, symbol = self.edges(index)
        values = intermediate[self.segment(index)[row], symbol]
        return np.asarray(np.bitwise_xor.reduceat(values, np.flatnonzero(np.diff(row, prepend=-1))))
