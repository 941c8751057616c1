"""Runs of the toy schemes in processes of their own, and what they leave."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from meshmark.research.benchmark.run.row import Row
from meshmark.research.benchmark.run.store import NAME, Store
from tests.research.benchmark import toy_schemes

# Whatever else differs between two runs is a fault.
CLOCKED = (
    "file_seconds",
    "embed_seconds",
    "attack_seconds",
    "extract_seconds",
    "vertices_per_second",
    "peak_mb",
)
DRIVER = """
import sys
from pathlib import Path
from meshmark.research.benchmark.run.run import Plan, run
if __name__ == "__main__":
    suite, models, out, scheme, limit = sys.argv[1:]
    where = {'data': Path(models), 'out': Path(out)}
    plan = Plan(suite=suite, **where, schemes=(scheme,), workers=2, time_limit=float(limit))
    run(plan)
"""


def install(folder: Path, schemes: Iterable[str]) -> None:
    """Make a folder for PYTHONPATH in which a package registers these toy schemes."""
    shutil.copy(toy_schemes.__file__, folder / "toy_schemes_of_elsewhere.py")
    info = folder / "toy_schemes-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: toy-schemes\nVersion: 1.0\n")
    points = "".join(f"{name.lower()} = toy_schemes_of_elsewhere:{name}\n" for name in schemes)
    (info / "entry_points.txt").write_text(f"[meshmark.schemes]\n{points}")


def driver(suite: str, models: Path, out: Path, scheme: str = "toy", limit: float = 600.0) -> list[str]:
    """Return the command of a run with two workers."""
    return [sys.executable, "-c", DRIVER, suite, str(models), str(out), scheme, str(limit)]


def numbers(rows: list[Row]) -> list[Row]:
    """Return the rows without what the clock says."""
    return [replace(row, **dict.fromkeys(CLOCKED)) for row in rows]


def rows_in(out: Path) -> list[Row]:
    """Return the finished cases in a folder of results."""
    if not (out / NAME).exists():
        return []
    with Store(out) as store:
        return store.rows()


def ended(group: int, within: float = 60.0) -> bool:
    """Whether every process of a group ends by itself."""
    end = time.monotonic() + within
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False
