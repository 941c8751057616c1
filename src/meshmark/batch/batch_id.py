"""The id of a model of a batch: by its file, its name and the key alone, so that every run gives the same copy."""

from __future__ import annotations

from hashlib import blake2b

from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, short_id

__all__ = ["batch_id"]

_PURPOSE, _PERSON = "ids of a batch", b"meshmark batch 1"


def batch_id(key: Key, name: str, digest: str, bits: int = ID_BITS) -> int | None:
    """Return the id of a model, of 64 or 32 bits; None where there are to be none.

    digest: SHA-256 of its file, hexadecimal; name: its place in the batch.
    """
    if not bits:
        return None
    content = f"{digest}\n{name}".encode("utf-8", "surrogateescape")
    word = blake2b(content, digest_size=8, key=key.subkey(_PURPOSE), person=_PERSON).digest()
    number = int.from_bytes(word, "little")
    return number if bits == ID_BITS else short_id(number % (1 << bits))
