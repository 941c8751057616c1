"""What a run was made with: the command, versions, machine and seed, so that every figure can be made again."""

from __future__ import annotations

import os
import platform
import shlex
import subprocess
import sys
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from meshmark import __version__

__all__ = ["Facts", "cores", "facts_of_now", "memory_mb"]

_PACKAGES = ("numpy", "scipy", "fast-simplification", "scikit-image", "gpytoolbox", "pebble")


@dataclass(frozen=True, kw_only=True)
class Facts:
    """Where a run's figures come from.

    command: as typed. schemes: name -> title and source. data: the folder of models, models: how many of them.
    started: UTC, ISO 8601. commit: of the git checkout the program runs from, "" where there is none.
    versions: of python, meshmark and the libraries that take part. processor, cores, memory_mb: the machine.
    seconds: wall-clock of all starts together; starts: how often the run was started (1 + resumed).
    """

    suite: str
    seed: int
    schemes: dict[str, str]
    data: str
    models: int
    command: str = ""
    started: str = ""
    commit: str = ""
    versions: dict[str, str] = field(default_factory=dict)
    system: str = ""
    processor: str = ""
    cores: int = 0
    memory_mb: int = 0
    workers: int = 1
    time_limit: float = 0.0
    worker_memory_mb: int = 0
    seconds: float = 0.0
    starts: int = 1

    def to_dict(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        return asdict(self)


def facts_of_now(
    suite: str, seed: int, schemes: dict[str, str], data: Path, models: int, **more: Any
) -> Facts:
    """Return the facts of a run that starts now, on this machine."""
    return Facts(
        suite=suite,
        seed=seed,
        schemes=schemes,
        data=str(data),
        models=models,
        command=shlex.join(["meshmark", *sys.argv[1:]]),
        started=datetime.now(UTC).isoformat(timespec="seconds"),
        commit=_commit(),
        versions={"python": platform.python_version(), "meshmark": __version__, **_versions()},
        system=platform.platform(),
        processor=_processor(),
        cores=cores(),
        memory_mb=memory_mb(),
        **more,
    )


def cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def memory_mb() -> int:
    """Return the memory this process may use: the machine's, or less where a container sets a limit; MiB."""
    limits = []
    if hasattr(os, "sysconf"):
        limits.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    for name in ("memory.max", "memory/memory.limit_in_bytes"):
        text = _first_line(Path("/sys/fs/cgroup") / name)
        if text.isdigit():
            limits.append(int(text))
    return min(limits, default=4 << 30) >> 20


def _versions() -> dict[str, str]:
    found = {}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _commit() -> str:
    folder = Path(__file__).parent
    try:
        result = subprocess.run(
            ["git", "-C", folder, "rev-parse", "HEAD"],
            capture_output=True,
            text=True,
            timeout=10,
            check=False,
        )
        tracked = subprocess.run(
            ["git", "-C", folder, "ls-files", "--error-unmatch", __file__],
            capture_output=True,
            timeout=10,
            check=False,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return result.stdout.strip() if result.returncode == tracked.returncode == 0 else ""


def _processor() -> str:
    for line in _text(Path("/proc/cpuinfo")).splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _first_line(path: Path) -> str:
    return (_text(path).splitlines() or [""])[0].strip()


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
