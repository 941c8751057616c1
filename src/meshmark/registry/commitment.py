"""What an owner can publish on the day a copy is made, and open later: a commitment to who got which copy.

    statement   JSON: id, digests of the original and of the marked file, recipient, time, fingerprint of the key,
                and `key_check`, 32 bytes derived from the key
    nonce       32 bytes derived from the key and the statement
    commitment  SHA-256(nonce, statement)

The commitment tells nothing of the statement, as nobody without the key knows the nonce. It is opened by showing
both; nobody, the owner included, can open it as another statement or, by `key_check`, for another key, without a
collision of SHA-256. Neither nonce nor `key_check` tells anything of the key.
"""

from __future__ import annotations

import hmac
import json
from dataclasses import asdict, dataclass
from hashlib import sha256
from typing import Final

from meshmark.coding.keys import Key

__all__ = ["Opening", "Statement", "key_check", "opening_of"]

_FORMAT: Final = "meshmark commitment 1"
_NONCE, _CHECK = "registry commitment nonce", "registry commitment check of the key"


@dataclass(frozen=True, kw_only=True)
class Statement:
    """What is committed to; digests, id and keys in hexadecimal; recipient: None where it was not said."""

    id: str
    original_digest: str
    marked_digest: str
    recipient: str | None
    issued_at: str
    key: str
    key_check: str

    def text(self) -> str:
        """Return the one spelling that is hashed."""
        values = {"format": _FORMAT, **asdict(self)}
        return json.dumps(values, sort_keys=True, separators=(",", ":"), ensure_ascii=True)


@dataclass(frozen=True, kw_only=True)
class Opening:
    """A statement with the nonce that opens its commitment, 64 hexadecimal digits."""

    statement: Statement
    nonce: str

    @property
    def commitment(self) -> str:
        """The commitment, 64 hexadecimal digits."""
        return sha256(bytes.fromhex(self.nonce) + self.statement.text().encode("ascii")).hexdigest()


def key_check(key: Key) -> str:
    """Return what ties a statement to one key: 64 hexadecimal digits, public."""
    return key.subkey(_CHECK).hex()


def opening_of(statement: Statement, key: Key) -> Opening:
    """Return the statement with the nonce that this key gives it."""
    nonce = hmac.digest(key.subkey(_NONCE), statement.text().encode("ascii"), sha256)
    return Opening(statement=statement, nonce=nonce.hex())
