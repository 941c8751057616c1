"""What a server is started with."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

__all__ = ["MEGABYTE", "Settings", "default_key_folder", "is_loopback"]

MEGABYTE = 1 << 20
_LOOPBACK = ("127.0.0.1", "::1", "localhost")


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What a server is started with.

    key_folder: where key files are. registry: place of the registry of copies, None without one; it may hold a
    password. token: what a client has to present, None where none is asked for. hosts: names by which the server
    may be addressed, besides IP addresses where it is bound to more than this computer.
    workers: jobs that run at once, at least 2, as one is kept free of large models. upload_bytes: most of one
    upload. small_bytes: uploads up to this are small. job_bytes: memory of one job; job_seconds: time of one job.
    kept_seconds: how long a finished job and its files are kept. waiting: most jobs that have not ended.
    """

    key_folder: Path
    registry: str | None = None
    token: str | None = field(default=None, repr=False)
    host: str = "127.0.0.1"
    hosts: tuple[str, ...] = ()
    workers: int = 2
    upload_bytes: int = 512 * MEGABYTE
    small_bytes: int = 8 * MEGABYTE
    job_bytes: int = 12288 * MEGABYTE
    job_seconds: float = 3600.0
    kept_seconds: float = 3600.0
    waiting: int = 64


def default_key_folder() -> Path:
    """Return where keys are kept without `--key-dir`: `meshmark/keys` in the user's folder of configuration."""
    home = os.environ.get("XDG_CONFIG_HOME") or (Path.home() / ".config")
    return Path(home) / "meshmark" / "keys"


def is_loopback(host: str) -> bool:
    """Return whether a server bound to this address is reached from this computer alone."""
    return host in _LOOPBACK or host.startswith("127.")
