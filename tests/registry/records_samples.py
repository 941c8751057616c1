"""Records that are not of any real model."""

from __future__ import annotations

from hashlib import sha256

from meshmark.registry.records import Copy, MarkedWith, Original

KEY, OTHER_KEY = "0123456789abcdef", "fedcba9876543210"
TIME = "2026-11-29T12:00:00Z"


def original(name: str = "hare.ply", descriptor: bytes | None = None) -> Original:
    return Original(
        digest=sha256(name.encode()).hexdigest(),
        name=name,
        points=100,
        registered_at=TIME,
        descriptor=descriptor,
    )


def copy(
    id: int, recipient: str | None = "Ann", name: str = "hare.ply", key: str = KEY, step: float = 0.05
) -> Copy:
    """Return a copy as `complete` takes it."""
    return Copy(
        id=id,
        key=key,
        original=original(name).digest,
        original_name=name,
        recipient=recipient,
        path=f"/out/{id:x}.ply",
        state="pending",
        mark=MarkedWith(
            strength="standard", layers="both", carriers="cells", lattice="0" * 32, spacing=0.25, step=step
        ),
        mark_format=4,
        meshmark="0.1.0",
        issued_at=TIME,
        marked_digest=sha256(f"{id}".encode()).hexdigest(),
        commitment=sha256(f"commitment {id}".encode()).hexdigest(),
    )
