"""Keyed pseudo-random functions: the same numbers from the same subkey on every machine.

All come from BLAKE2b in its keyed mode (RFC 7693), which is a pseudo-random function; what is computed from
its output uses only operations that IEEE 754 rounds exactly (+, -, *, /, sqrt), never a library's sine.
"""

from __future__ import annotations

import math
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import InputError
from meshmark.mesh import FloatArray, IntArray

__all__ = ["cell_words", "keyed_bits", "keyed_words", "offset", "rotation", "unit_interval"]

_CELL = b"meshmark cell 1"
_STREAM = b"meshmark strm 1"
_BLOCK = 64
_MAX_WORDS = _BLOCK // 8
_UNIT = 2.0**-53


def cell_words(subkey: bytes, coordinates: IntArray, words: int = 4) -> NDArray[np.uint64]:
    """Return 1 to 8 pseudo-random 64-bit words for each row of integer coordinates (n, d): (n, words).

    Word by word the BLAKE2b digest of the row, as little-endian int64, under the subkey. About 1 us per row.
    """
    if not 1 <= words <= _MAX_WORDS:
        raise InputError(f"{words} words per cell asked for, expected 1 to {_MAX_WORDS}")
    rows = np.ascontiguousarray(coordinates, dtype="<i8")
    data, width, size = memoryview(rows.tobytes()), 8 * rows.shape[1], 8 * words
    # A copy takes half the time of a new one with the key.
    keyed = blake2b(digest_size=size, key=subkey, person=_CELL).copy
    digests = []
    for start in range(0, len(data), width):
        digest = keyed()
        digest.update(data[start : start + width])
        digests.append(digest.digest())
    return np.frombuffer(b"".join(digests), dtype="<u8").astype(np.uint64).reshape(len(rows), words)


def unit_interval(words: NDArray[np.uint64]) -> FloatArray:
    """Map 64-bit words to numbers in [0, 1), by their top 53 bits."""
    return np.asarray((words >> np.uint64(11)).astype(np.float64) * _UNIT)


def keyed_words(subkey: bytes, count: int) -> NDArray[np.uint64]:
    """Return the first `count` 64-bit words of the subkey's pseudo-random stream: BLAKE2b of a counter."""
    blocks = (
        blake2b(block.to_bytes(8, "little"), digest_size=_BLOCK, key=subkey, person=_STREAM).digest()
        for block in range(-(-count // _MAX_WORDS))
    )
    return np.frombuffer(b"".join(blocks), dtype="<u8")[:count].astype(np.uint64)


def keyed_bits(subkey: bytes, count: int) -> NDArray[np.uint8]:
    """Return the first `count` bits of the subkey's pseudo-random stream, shape (count,), values 0 and 1."""
    stream = keyed_words(subkey, -(-count // 64)).astype("<u8").view(np.uint8)
    return np.unpackbits(stream, count=count, bitorder="little")


def offset(subkey: bytes) -> FloatArray:
    """Return three pseudo-random numbers in [0, 1): (3,)."""
    return unit_interval(keyed_words(subkey, 3))


def rotation(subkey: bytes) -> FloatArray:
    """Return a pseudo-random rotation matrix (3, 3), uniform over all rotations.

    A point uniform in the unit 4-ball (by rejection), normalised, is a uniform unit quaternion.
    """
    attempts = 1
    while True:
        words = keyed_words(subkey, 4 * attempts)[-4:]
        w, x, y, z = (2.0 * float(part) - 1.0 for part in unit_interval(words))
        square = w * w + x * x + y * y + z * z
        if 0.01 < square <= 1.0:
            break
        attempts += 1
    norm = math.sqrt(square)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
