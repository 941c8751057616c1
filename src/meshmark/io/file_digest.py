"""The digest by which a file is named where its content must be the same: in registries, batches and reports."""

from __future__ import annotations

from hashlib import file_digest
from pathlib import Path

__all__ = ["digest_of_file"]


def digest_of_file(path: Path) -> str:
    """Return SHA-256 of what a file holds, 64 hexadecimal digits; raises `OSError` where it cannot be read."""
    with path.open("rb") as stream:
        return file_digest(stream, "sha256").hexdigest()
