"""The rows of a registry as values."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from meshmark.coding.message import format_id

__all__ = ["Copy", "MarkedWith", "Original"]


@dataclass(frozen=True, kw_only=True)
class Original:
    """A model that copies were made of.

    digest: `digest_of_mesh`, 64 hexadecimal digits; name: of its file; points: different ones; descriptor: the
    bytes of `shape_descriptor`, None where they are not known.
    """

    digest: str
    name: str
    points: int
    registered_at: str
    descriptor: bytes | None = None


@dataclass(frozen=True, kw_only=True)
class MarkedWith:
    """How a mark lies in a copy: what copies have in common that one certificate can register.

    carriers: "cells" or "points"; lattice: its label, 32 hexadecimal digits; spacing, step: as a certificate has
    them.
    """

    strength: str
    layers: str
    carriers: str
    lattice: str
    spacing: float
    step: float


@dataclass(frozen=True, kw_only=True)
class Copy:
    """A marked copy, or an id that is held for one.

    id: 64-bit; key: public fingerprint of the key; original: digest, original_name: of its file. state: "issued",
    or "pending" where the file has not (or not surely) taken its name. Until the file was complete, mark and all
    after it are None. marked_digest: SHA-256 of the file; commitment: what can be published (`commitment`).
    """

    id: int
    key: str
    original: str
    original_name: str
    recipient: str | None
    path: str | None
    state: str
    mark: MarkedWith | None
    mark_format: int | None
    meshmark: str | None
    issued_at: str | None
    marked_digest: str | None
    commitment: str | None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields, the id in hexadecimal; `original` is the name of its file."""
        mark = {entry.name: getattr(self.mark, entry.name, None) for entry in fields(MarkedWith)}
        return {
            "id": format_id(self.id),
            "recipient": self.recipient,
            "original": self.original_name,
            "issued_at": self.issued_at,
            "path": self.path,
            "state": self.state,
            "key": self.key,
            "original_digest": self.original,
            **mark,
            "mark_format": self.mark_format,
            "meshmark": self.meshmark,
            "marked_digest": self.marked_digest,
            "commitment": self.commitment,
        }
