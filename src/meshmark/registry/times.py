"""Times in a registry: UTC, to the second, as text that sorts by time."""

from __future__ import annotations

import re
from datetime import UTC, datetime

from meshmark.errors import InputError

__all__ = ["check_time", "now"]

_TIME = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")


def now() -> str:
    """Return the time: "2026-11-29T13:40:00Z"."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def check_time(text: str) -> str:
    """Return a time as it is written; raises `InputError` for anything else."""
    if not _TIME.fullmatch(text):
        raise InputError(f"the time {text!r} is not valid, expected one like 2026-11-29T13:40:00Z")
    return text
