"""A keyed permutation of ids of 64 bits, or fewer: a Feistel network of four rounds of keyed BLAKE2b.

The code is linear: without a permutation the sum of three code words would be the word of the sum of their ids, and
three customers could put together a copy that names a fourth. With it the sum decodes to an id that nobody chose.
Four rounds with a pseudorandom round function are a pseudorandom permutation, in both directions (Luby and Rackoff
1988, doi:10.1137/0217022).
"""

from __future__ import annotations

from hashlib import blake2b

__all__ = ["IdPermutation"]

ROUNDS = 4


class IdPermutation:
    """The permutation of a subkey (bytes, at most 64), of numbers of `bits` bits: 16, 32, 48 or 64."""

    def __init__(self, subkey: bytes, bits: int = 64) -> None:
        self._half = bits // 2
        self._rounds = [
            blake2b(bytes([number]), key=subkey, digest_size=32).digest() for number in range(ROUNDS)
        ]

    def forward(self, identity: int) -> int:
        """Return the image of an id."""
        left, right = self._halves(identity)
        for subkey in self._rounds:
            left, right = right, left ^ self._mixed(subkey, right)
        return left << self._half | right

    def backward(self, image: int) -> int:
        """Return the id of an image."""
        left, right = self._halves(image)
        for subkey in reversed(self._rounds):
            left, right = right ^ self._mixed(subkey, left), left
        return left << self._half | right

    def _halves(self, number: int) -> tuple[int, int]:
        return number >> self._half, number & (1 << self._half) - 1

    def _mixed(self, subkey: bytes, half: int) -> int:
        digest = blake2b(half.to_bytes(4, "big"), key=subkey, digest_size=self._half // 8).digest()
        return int.from_bytes(digest, "big")
