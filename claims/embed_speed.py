"""Time and memory of embedding and extraction (ownership layer), beside trimesh on the same OBJ file.

python -m claims.embed_speed [--repeats 5]

Prints, for about 35,000, 190,000 and 775,000 points: seconds and the ratio to trimesh, for reading an OBJ file,
marking it, writing it and reading it back (bar: 3 times at 35,000), and for reading and extracting (bar: 1 time);
the exponent with which both grow; and the peak memory of the largest, each step in a process of its own.

No page quotes its figures yet; docs/claims.md says what it prints.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np
import trimesh

from claims.models import DATA, load
from meshmark.coding.keys import Key
from meshmark.io import read_mesh, write_mesh
from meshmark.marking import extract
from meshmark.marking.marked_file import embed_file

MODELS = (
    "models/test/bunny_34834.off.xz",
    "large/icecream_dispenser_190553.off.xz",
    "large/horse_loop2_775730.ply.xz",
)
KEY = Key(bytes(range(32)))


def seconds(work: Callable[[], object]) -> float:
    """Wall time of one call."""
    start = perf_counter()
    work()
    return perf_counter() - start


def by_trimesh(path: Path) -> None:
    trimesh.load(path).export(path.with_name("trimesh.obj"))


def measure(name: str, folder: Path, repeats: int) -> tuple[int, float, float]:
    """Return points and median seconds of embedding and extraction; prints them with their ratios."""
    plain, marked = folder / "plain.obj", folder / "marked.obj"
    mesh = load(DATA / name)
    write_mesh(mesh, plain)
    times = []
    for _ in range(repeats):  # in turn, so that a slow spell of the machine meets all three
        beside = seconds(lambda: by_trimesh(plain))
        embedding = seconds(lambda: embed_file(plain, marked, KEY, id=7, layers="ownership"))
        extraction = seconds(lambda: extract(read_mesh(marked), KEY))
        times.append((beside, embedding, extraction))
    rows = np.array(times)
    ratio = [median(rows[:, i] / rows[:, 0]) for i in (1, 2)]
    beside, embedding, extraction = np.median(rows, axis=0)
    print(
        f"{len(mesh.vertices):>7} points: trimesh {beside:.2f} s; embed + verify {embedding:.2f} s, "
        f"{ratio[0]:.2f} times; extract {extraction:.2f} s, {ratio[1]:.2f} times",
        flush=True,
    )
    return len(mesh.vertices), float(embedding), float(extraction)


def peak(step: str, folder: Path) -> float:
    """Peak memory in GB of one step in a process of its own."""
    code = f"from claims.embed_speed import run_step; run_step({step!r}, {str(folder)!r})"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return float(done.stdout)


def run_step(step: str, folder: str) -> None:
    """Run one step and print this process's peak memory in GB."""
    plain, marked = Path(folder) / "plain.obj", Path(folder) / "marked.obj"
    if step == "embed":
        embed_file(plain, marked, KEY, id=7, layers="ownership")
    else:
        extract(read_mesh(marked), KEY)
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = [measure(MODELS[0], folder, repeats), *(measure(model, folder, 1) for model in MODELS[1:])]
        growth = np.log(np.array(rows)[-1] / np.array(rows)[0])
        print(
            f"growth from first to last: embed n^{growth[1] / growth[0]:.2f}, extract n^{growth[2] / growth[0]:.2f}"
        )
        for step in ("embed", "extract"):
            print(f"peak memory of {step} at {rows[-1][0]} points: {peak(step, folder):.2f} GB")


if __name__ == "__main__":
    main()
