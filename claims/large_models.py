"""Processor time and peak memory of every operation on a model of millions of points.

python -m claims.large_models ROWS.csv --points 5000000 [--folder FOLDER] [--only OPERATION ...] [--minutes M]

A training model is subdivided to about so many points, with a relief of a thousandth of its extent, and kept as a
binary PLY file of 32-bit floats, as scans are. Each operation then runs in a process of its own, on one thread: its
user and system seconds, its peak memory (resident), and what it answers. A row is written as soon as an operation
is done; run it again to continue. Exits with 1 where an operation takes more memory than its bar, fails, or answers
wrongly.

Figures of docs/performance.md.
"""

from __future__ import annotations

import argparse
import csv
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import numpy as np

from claims.models import DATA, load
from claims.performance import KEY, peak, used
from claims.princeton import read_rows
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray

ID = 7
# Model that is subdivided, and how often, by the points that come out, about.
SOURCES = {
    540_000: ("models/train/open_nefertiti-lowres.off.xz", 2),
    1_300_000: ("models/train/classic_elk.off.xz", 4),
    2_600_000: ("models/train/classic_foot.off.xz", 4),
    5_000_000: ("models/train/horse_19851.off.xz", 4),
}
# Most GB of an operation, on models of up to this number of points.
MEMORY = {800_000: 1.5, 10_000_000: 8.0}
COLUMNS = ("points", "operation", "seconds", "peak_gb", "answer")
# Points whose relief is made at once.
BLOCK = 1 << 18
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True, kw_only=True)
class Operation:
    """work: on the folder of the models, returns the answer; needs: the file it reads; expected: the answer."""

    work: Callable[[Path], str]
    needs: str
    expected: str


def embed(folder: Path, layers: str) -> str:
    """Mark the plain model."""
    from meshmark.marking.marked_file import embed_file

    return embed_file(folder / "plain.ply", folder / f"{layers}.ply", KEY, id=ID, layers=layers).layers


def extract(folder: Path, name: str) -> str:
    """Read the id of a model."""
    from meshmark.io import read_mesh
    from meshmark.marking import extract as extract_id

    found = extract_id(read_mesh(folder / f"{name}.ply"), KEY)
    return found.presence if found.id is None else f"id {found.id}"


def authenticate(folder: Path, name: str) -> str:
    """Judge a model."""
    from meshmark.io import read_mesh
    from meshmark.marking import authenticate as judge

    return judge(read_mesh(folder / f"{name}.ply"), KEY).verdict


OPERATIONS = {
    "embed ownership": Operation(
        work=lambda folder: embed(folder, "ownership"), needs="plain", expected="ownership"
    ),
    "extract, id alone": Operation(
        work=lambda folder: extract(folder, "ownership"), needs="ownership", expected=f"id {ID}"
    ),
    "authenticate, id alone": Operation(
        work=lambda folder: authenticate(folder, "ownership"), needs="ownership", expected="inconclusive"
    ),
    "extract, not marked (quick)": Operation(
        work=lambda folder: extract(folder, "plain"), needs="plain", expected="absent"
    ),
    "authenticate, not marked": Operation(
        work=lambda folder: authenticate(folder, "plain"), needs="plain", expected="not marked"
    ),
    "embed both": Operation(work=lambda folder: embed(folder, "both"), needs="plain", expected="both"),
    "extract, both": Operation(
        work=lambda folder: extract(folder, "both"), needs="both", expected=f"id {ID}"
    ),
    "authenticate, both": Operation(
        work=lambda folder: authenticate(folder, "both"), needs="both", expected="authentic"
    ),
}


def make(points: int, folder: str) -> None:
    """Write the plain model, subdivided to about so many points."""
    import trimesh

    name, times = SOURCES[points]
    plain = weld(load(DATA / name))
    vertices, faces = trimesh.remesh.subdivide_loop(plain.points, plain.faces, iterations=times)
    surface = trimesh.Trimesh(vertices, faces, process=False)
    del vertices, faces
    normals = np.array(surface.vertex_normals)
    surface._cache.clear()
    surface.vertices = with_relief(np.array(surface.vertices), normals)
    surface.export(Path(folder) / "plain.ply", vertex_normal=False)


def with_relief(points: FloatArray, normals: FloatArray) -> FloatArray:
    """Return points (p, 3) moved along their normals by a thousandth of the extent, no two rings alike."""
    extent, rng = float(np.ptp(points, axis=0).max()), np.random.default_rng(0)
    waves = rng.normal(size=(30, 3)) * 60.0 / extent
    phase = rng.uniform(0.0, 2.0 * np.pi, 30)
    for start in range(0, len(points), BLOCK):
        block = slice(start, start + BLOCK)
        height = np.sin(points[block] @ waves.T + phase).mean(axis=1)
        points[block] += 1e-3 * extent * height[:, None] * normals[block]
    return points


def run(name: str, folder: str) -> None:
    """Run one operation; print its seconds, the peak memory of its process in GB, and its answer."""
    before = used()
    answer = OPERATIONS[name].work(Path(folder))
    print(used() - before, peak(), answer)


def python(code: str) -> str:
    """Return what a process of its own prints."""
    done = subprocess.run(
        [sys.executable, "-c", f"import claims.large_models as c; {code}"],
        check=False, stdout=subprocess.PIPE, text=True, env=os.environ | ONE_THREAD,
    )  # fmt: skip
    return done.stdout if done.returncode == 0 else f"nan nan failed: {done.returncode}"


def measure(options: argparse.Namespace, folder: Path) -> None:
    """Measure what has no row yet."""
    end = monotonic() + 60.0 * options.minutes
    known = {row["operation"] for row in read_rows(options.rows) if int(row["points"]) == options.points}
    fresh = not options.rows.exists() or not options.rows.stat().st_size
    if not (folder / "plain.ply").exists():
        python(f"c.make({options.points}, {str(folder)!r})")
    with options.rows.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        if fresh:
            writer.writerow(COLUMNS)
        for name in options.only or OPERATIONS:
            there = (folder / f"{OPERATIONS[name].needs}.ply").exists()
            if name in known or not there or monotonic() > end:
                continue
            seconds, memory, answer = python(f"c.run({name!r}, {str(folder)!r})").strip().split(maxsplit=2)
            writer.writerow([options.points, name, seconds, memory, answer])
            file.flush()


def report(rows: list[dict[str, str]]) -> bool:
    """Print the rows as a table in Markdown, and return whether all are within their bars."""
    good = True
    print("| points, about | operation | seconds | peak, GB | answer | |\n|---|---|---|---|---|---|")
    for row in rows:
        points, memory = int(row["points"]), float(row["peak_gb"])
        bar = next(bar for most, bar in MEMORY.items() if points <= most)
        right = memory <= bar and row["answer"] == OPERATIONS[row["operation"]].expected
        good = good and right
        cells = (f"{points:,}", row["operation"], f"{float(row['seconds']):.1f}", f"{memory:.2f}")
        print("|", " | ".join((*cells, row["answer"], "" if right else "missed")), "|")
    return good


def main() -> int:
    """Measure and print; exit 1 where a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("rows", type=Path)
    parser.add_argument("--points", type=int, choices=SOURCES, default=5_000_000)
    parser.add_argument("--folder", type=Path, help="keeps the models, for another run")
    parser.add_argument("--only", nargs="+", choices=OPERATIONS)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = options.folder or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        measure(options, folder)
    return int(not report(read_rows(options.rows)))


if __name__ == "__main__":
    sys.exit(main())
