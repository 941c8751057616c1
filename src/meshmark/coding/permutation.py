"""A keyed permutation of 64-bit ids: a Feistel network of four rounds of keyed BLAKE2b.

The code is linear: without a permutation the sum of three code words would be the word of the sum of their ids, and
three customers could put together a copy that names a fourth. With it the sum decodes to an id that nobody chose.
Four rounds with a pseudorandom round function are a pseudorandom permutation, in both directions (Luby and Rackoff
1988, doi:10.1137/0217022).
"""

from __future__ import annotations

from hashlib import blake2b

__all__ = ["IdPermutation"]

ROUNDS = 4
_HALF = 32
_LOW = (1 << _HALF) - 1


class IdPermutation:
    """The permutation of a subkey (bytes, at most 64)."""

    def __init__(self, subkey: bytes) -> None:
        self._rounds = [
            blake2b(bytes([number]), key=subkey, digest_size=32).digest() for number in range(ROUNDS)
        ]

    def forward(self, identity: int) -> int:
        """Return the image of an id."""
        left, right = identity >> _HALF, identity & _LOW
        for subkey in self._rounds:
            left, right = right, left ^ _mixed(subkey, right)
        return left << _HALF | right

    def backward(self, image: int) -> int:
        """Return the id of an image."""
        left, right = image >> _HALF, image & _LOW
        for subkey in reversed(self._rounds):
            left, right = right ^ _mixed(subkey, left), left
        return left << _HALF | right


def _mixed(subkey: bytes, half: int) -> int:
    digest = blake2b(half.to_bytes(4, "big"), key=subkey, digest_size=4).digest()
    return int.from_bytes(digest, "big")
