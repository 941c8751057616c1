"""A file that appears complete or not at all."""

from __future__ import annotations

from pathlib import Path

from meshmark.io.staging import Staging

__all__ = ["write_whole"]


def write_whole(path: Path | str, data: bytes, staging: Staging | None = None) -> None:
    """Write `data` under a temporary name beside `path`, then rename it; a link is followed.

    staging: takes the file, to move it into place together with others; without it that is done at once.
    Raises `OutputError` where that fails; what was at `path` before is then still there.
    """
    if staging is not None:
        staging.put(path, data)
        return
    with Staging() as own:
        own.put(path, data)
