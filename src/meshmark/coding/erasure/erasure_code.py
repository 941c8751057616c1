"""An erasure code without order: any large enough set of symbols gives the message, even with a few wrong ones.

A fountain code after Luby (doi:10.1109/SFCS.2002.1181950) and Shokrollahi (doi:10.1109/TIT.2006.874390): every
32-bit index has a symbol of its own, the exclusive or of a few intermediate symbols that the index names; sparse
and dense parities tie the intermediate symbols together. Long messages are cut into segments. One index in 32 tells
the size of the message instead. What is decoded is vouched for by 32 bits of a hash.
"""

from __future__ import annotations

from functools import lru_cache
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.erasure.graph import Graph, mix, sizes
from meshmark.coding.erasure.solver import ENOUGH, solve
from meshmark.errors import CapacityError, InputError
from meshmark.mesh import IntArray

__all__ = ["SYMBOL_BITS", "ErasureCode", "capacity", "decode"]

SYMBOL_BITS = (1, 16)
"""Least and most bits of a symbol."""
CHECK_BYTES = 4
# One index in PILOT names the size; a size is believed only if it is among the LIKELIEST.
PILOT = 32
LIKELIEST = 6
# Of MANY pilots or more, at least this share agree with a size that is tried: with one symbol of ten wrong fewer
# agree with the right one once in a thousand times.
MANY, AGREEING = 3, 1 / 3
# Symbols that decoding needs beyond those of the message: EXCESS_SHARE of these, and EXCESS in each segment.
EXCESS_SHARE, EXCESS = 0.03, 12
_PERSON = b"meshmark payload"
_WHITE = b"meshmark white 1"

Symbols = NDArray[np.uint16]


class ErasureCode:
    """The symbols of one message; `code(index)` gives those of any indices.

    message: bytes; symbol_bits: 1 to 16 bits a symbol. size: intermediate message symbols, all segments together.
    Raises `InputError` for other symbol sizes, `CapacityError` for a message that is too long for the code.
    """

    def __init__(self, message: bytes, symbol_bits: int) -> None:
        _check_bits(symbol_bits)
        body = _whiten(blake2b(message, digest_size=CHECK_BYTES, person=_PERSON).digest() + message + b"\x80")
        wanted = -(-8 * len(body) // symbol_bits)
        self._ladder = int(np.searchsorted(sizes(), wanted))
        if self._ladder == len(sizes()):
            most = int(sizes()[-1]) * symbol_bits // 8 - CHECK_BYTES - 1
            raise CapacityError(f"the payload has {len(message)} bytes, expected at most {most}")
        self.symbol_bits = symbol_bits
        self.size = int(sizes()[self._ladder])
        self._graph = Graph(self.size)
        padded = body + _whiten(bytes(-(-self.size * symbol_bits // 8)))[len(body) :]
        bits = np.unpackbits(np.frombuffer(padded, np.uint8))[: self.size * symbol_bits]
        self._intermediate = self._graph.intermediate(_symbols(bits, symbol_bits))

    def __call__(self, index: NDArray[np.uint32]) -> Symbols:
        """Return (m,): the symbols of the indices (m,)."""
        index = np.asarray(index, dtype=np.uint32)
        values = self._graph.outputs(self._intermediate, index)
        pilot = _is_pilot(index)
        values[pilot] = _pilot_values(index[pilot], self._ladder, self.symbol_bits)
        return values


def capacity(symbols: int, symbol_bits: int) -> int:
    """Return how many bytes can nearly always be decoded from this many right symbols of random indices."""
    _check_bits(symbol_bits)
    pilots = symbols / PILOT
    usable = symbols - pilots - 2.0 * pilots**0.5
    counts = sizes()[sizes() >= 1]
    segments = Graph.segments_of(counts)
    # Symbols fall into segments at random: the emptiest of them must have enough.
    spread = np.where(segments > 1, 3.5 * np.sqrt(counts * segments), 0.0)
    needed = counts * (1.0 + EXCESS_SHARE) + EXCESS * segments + spread
    fits = np.flatnonzero(needed <= usable)
    if not len(fits):
        return 0
    return max(int(counts[fits[-1]]) * symbol_bits // 8 - CHECK_BYTES - 1, 0)


def decode(index: NDArray[np.uint32], value: Symbols, symbol_bits: int) -> bytes | None:
    """Return the message from symbols (k,) and their indices (k,) in any order, or None.

    A per cent or two of the symbols may be wrong where there are some more than needed. Of an index that occurs
    more than once the value that most give counts.
    """
    _check_bits(symbol_bits)
    index, value = _once(np.asarray(index, np.uint32), np.asarray(value, np.uint16))
    return _message(index.tobytes(), value.tobytes(), symbol_bits)


@lru_cache(maxsize=8)
def _message(indices: bytes, values: bytes, symbol_bits: int) -> bytes | None:
    """Return the message of symbols that each occur once.

    The same symbols are often decoded several times, a model being read after each rounding that it is to bear.
    """
    index, value = np.frombuffer(indices, np.uint32), np.frombuffer(values, np.uint16)
    pilot = _is_pilot(index)
    data, held = index[~pilot], value[~pilot]
    for ladder in _likely_sizes(index[pilot], value[pilot], symbol_bits, len(data)):
        graph = Graph(int(sizes()[ladder]))
        for enough in (ENOUGH, 1.0):
            found = solve(graph, data, held, symbol_bits, enough)
            if found is None:
                break
            if (message := _opened(found, symbol_bits)) is not None:
                return message
    return None


def _once(index: NDArray[np.uint32], value: Symbols) -> tuple[NDArray[np.uint32], Symbols]:
    """Return each index once: repeated equations say nothing new, and wrong ones would be taken as often."""
    pairs, times = np.unique(index.astype(np.uint64) << np.uint64(16) | value, return_counts=True)
    pairs = pairs[np.argsort(-times, kind="stable")]
    names, first = np.unique(pairs >> np.uint64(16), return_index=True)
    return names.astype(np.uint32), pairs[first].astype(np.uint16)


def _check_bits(symbol_bits: int) -> None:
    low, high = SYMBOL_BITS
    if not low <= symbol_bits <= high:
        raise InputError(f"symbols of {symbol_bits} bits cannot be coded, expected {low} to {high}")


def _is_pilot(index: NDArray[np.uint32]) -> NDArray[np.bool_]:
    return np.asarray(mix(index, 1) % np.uint64(PILOT) == 0)


def _pilot_values(index: NDArray[np.uint32], ladder: int | IntArray, symbol_bits: int) -> Symbols:
    words = mix(index, 2 + np.asarray(ladder))
    return np.asarray(words >> np.uint64(64 - symbol_bits)).astype(np.uint16)


def _likely_sizes(index: NDArray[np.uint32], value: Symbols, symbol_bits: int, count: int) -> IntArray:
    """Return the sizes that agree with most pilots, best first, of those that `count` symbols can give."""
    ladder = np.flatnonzero(sizes() <= count)
    if not len(ladder):
        return ladder
    agree = (_pilot_values(index[:, None], ladder, symbol_bits) == value[:, None]).sum(axis=0)
    order = np.argsort(-agree, kind="stable")[:LIKELIEST]
    least = max(0.5 * agree[order[0]], AGREEING * len(index) if len(index) >= MANY else 0.0)
    return np.asarray(ladder[order[agree[order] >= least]])


def _opened(found: Symbols, symbol_bits: int) -> bytes | None:
    planes = np.arange(symbol_bits - 1, -1, -1, dtype=np.uint16)
    bits = (found[:, None] >> planes) & np.uint16(1)
    body = _whiten(np.packbits(bits.astype(np.uint8).ravel()).tobytes())
    body = body[: len(found) * symbol_bits // 8]
    content = body.rstrip(b"\0")
    if not content.endswith(b"\x80"):
        return None
    check, message = content[:CHECK_BYTES], content[CHECK_BYTES:-1]
    right = blake2b(message, digest_size=CHECK_BYTES, person=_PERSON).digest() == check
    return message if right else None


def _symbols(bits: NDArray[np.uint8], symbol_bits: int) -> Symbols:
    weights = 1 << np.arange(symbol_bits - 1, -1, -1)
    return np.asarray(bits.reshape(-1, symbol_bits) @ weights).astype(np.uint16)


def _whiten(content: bytes) -> bytes:
    """Exchange bytes with a fixed random stream's exclusive or, so that zeros are no special message."""
    words = mix(np.arange(-(-len(content) // 8), dtype=np.uint32), 0).astype("<u8")
    stream = np.frombuffer(words.tobytes(), np.uint8)[: len(content)]
    return (np.frombuffer(content, np.uint8) ^ stream).tobytes()
