"""Memory of this process: its peak, and a limit on it. Both do nothing on systems without the means."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path

__all__ = ["forget_peak", "limit_memory", "peak_mb"]

_STATUS = Path("/proc/self/status")


def limit_memory(megabytes: int) -> None:
    """Let allocations beyond this number of MiB fail with `MemoryError`."""
    if sys.platform == "win32":
        return
    import resource

    # On Linux the data limit covers what is allocated, without the libraries that are only mapped.
    kind = resource.RLIMIT_DATA if sys.platform == "linux" else resource.RLIMIT_AS
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(kind, (megabytes << 20, resource.getrlimit(kind)[1]))


def forget_peak() -> None:
    """Start the peak anew from what is in use now."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def peak_mb() -> float | None:
    """Return the most memory in use since `forget_peak`, or since the process began; MiB."""
    with contextlib.suppress(OSError):
        for line in _STATUS.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024.0
    if sys.platform == "win32":
        return None
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (
        1 << 20 if sys.platform == "darwin" else 1 << 10
    )
