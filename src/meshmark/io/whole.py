"""A file that appears complete or not at all."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from meshmark.errors import OutputError

__all__ = ["write_whole"]


def write_whole(path: Path | str, data: bytes) -> None:
    """Write `data` under a temporary name beside `path`, then rename it; a link is followed.

    Raises `OutputError` where that fails; what was at `path` before is then still there.
    """
    target = Path(os.path.realpath(path))
    spare = target.with_name(f".{target.name[:80]}.{secrets.token_hex(6)}.tmp")
    try:
        try:
            with spare.open("xb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            spare.replace(target)
        finally:
            spare.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from None
