"""What a run cost: vertices per second and peak memory (paper eq. 16, docs/design.md, section 11)."""

from __future__ import annotations

import sys

from meshmark.errors import InputError

__all__ = ["peak_memory_mb", "vertices_per_second"]


def vertices_per_second(vertices: int, seconds: float) -> float:
    """Return the vertices worked through per second of wall-clock time; raises `InputError` for no time."""
    if not seconds > 0.0:
        raise InputError(f"{seconds:g} seconds passed, expected more than 0")
    return vertices / seconds


def peak_memory_mb() -> float:
    """Return the most memory this process has held so far, in MiB.

    Raises `InputError` where the system does not tell (Windows).
    """
    try:
        import resource
    except ImportError as error:
        raise InputError(
            "this system does not tell the peak memory of a process, expected Linux or macOS"
        ) from error
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)  # macOS counts bytes, Linux KiB
