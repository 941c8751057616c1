"""Random numbers of a benchmark: each a hash of what it is for, so that any case can be run again alone."""

from __future__ import annotations

import hashlib
import json

import numpy as np

from meshmark.coding.keys import Key

__all__ = ["bits_for", "generator_for", "hashed", "key_for"]


def hashed(*parts: str | int) -> bytes:
    """Return 32 bytes that depend on every part and on their order (BLAKE2b of the parts as JSON)."""
    return hashlib.blake2b(json.dumps(parts).encode(), digest_size=32, person=b"meshmark bench").digest()


def key_for(*parts: str | int) -> Key:
    """Return the key for these parts."""
    return Key(hashed("key", *parts))


def bits_for(count: int, *parts: str | int) -> np.ndarray[tuple[int], np.dtype[np.uint8]]:
    """Return `count` random payload bits, (count,) uint8, for these parts."""
    return generator_for("bits", *parts).integers(0, 2, count, dtype=np.uint8)


def generator_for(*parts: str | int) -> np.random.Generator:
    """Return a generator seeded by these parts."""
    return np.random.default_rng(list(hashed("generator", *parts)))
