"""The id of a model of a batch: by its file, its name and the key alone, so that every run gives the same copy."""

from __future__ import annotations

from hashlib import blake2b

from meshmark.coding.keys import Key

__all__ = ["batch_id"]

_PURPOSE, _PERSON = "ids of a batch", b"meshmark batch 1"


def batch_id(key: Key, name: str, digest: str) -> int:
    """Return the 64 bits of a model; digest: SHA-256 of its file, hexadecimal; name: its place in the batch."""
    content = f"{digest}\n{name}".encode("utf-8", "surrogateescape")
    word = blake2b(content, digest_size=8, key=key.subkey(_PURPOSE), person=_PERSON).digest()
    return int.from_bytes(word, "little")
