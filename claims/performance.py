"""Processor time and memory of each operation, beside trimesh's load and export of the same OBJ file.

python -m claims.performance [MODEL ...] [--sizes 5000 50000 540000] [--repeats 1] [--profile OPERATION]

Each operation runs in a process of its own, on one thread, and is measured there: user and system time of the
operation alone and of the whole process, and its peak memory. Trimesh's runs before and after the operations of a
model; the ratio is to the mean of both. Without a MODEL, training models are subdivided to about these sizes, with
a relief of a thousandth of their extent, so that no two rings are alike. Prints a table in Markdown, with the bar
of each ratio, and exits with 1 where one is missed. --profile prints where the time of one operation goes instead.

Figures of docs/performance.md.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from claims.models import DATA, load
from meshmark.coding.keys import Key
from meshmark.geometry.weld import weld
from meshmark.io import read_mesh, write_mesh
from meshmark.mesh import Mesh

KEY = Key(bytes(range(32)))
TRIMESH = "trimesh: load, export OBJ"
# Model that is subdivided, and how often, by the points that come out, about.
SOURCES = {
    5_000: ("models/train/classic_elk.off.xz", 0),
    50_000: ("models/train/classic_mannequin-devil.off.xz", 1),
    540_000: ("models/train/open_nefertiti-lowres.off.xz", 2),
}
LARGE = 300_000
# Most GB of an operation on a large model, and most seconds of embedding both layers into one of 5,000 points.
MEMORY, COLD = 1.5, 1.0


@dataclass(frozen=True, kw_only=True)
class Operation:
    """work: on the folder that has plain.obj and marked.obj; bars: ratio at 50,000 points, and above `LARGE`."""

    work: Callable[[Path], object]
    bars: tuple[float | None, float | None] = (None, None)


def by_trimesh(folder: Path) -> None:
    from claims.embed_speed import by_trimesh as load_and_export

    load_and_export(folder / "plain.obj")


def embed(folder: Path, layers: str, payload: str | None) -> None:
    from meshmark.marking.marked_file import embed_file

    out = folder / ("marked.obj" if payload == "miniature" else "other.obj")
    embed_file(folder / "plain.obj", out, KEY, id=7, layers=layers, payload=payload)


def extract(folder: Path, name: str) -> None:
    from meshmark.marking import extract as extract_id

    extract_id(read_mesh(folder / name), KEY, search="quick")


def authenticate(folder: Path) -> None:
    from meshmark.marking import authenticate as judge

    judge(read_mesh(folder / "marked.obj"), KEY)


OPERATIONS = {
    TRIMESH: Operation(work=by_trimesh),
    "embed ownership": Operation(work=lambda folder: embed(folder, "ownership", None), bars=(1.2, 2.5)),
    "embed both, no payload": Operation(work=lambda folder: embed(folder, "both", "none")),
    "embed both, miniature": Operation(
        work=lambda folder: embed(folder, "both", "miniature"), bars=(2.5, 5.0)
    ),
    "extract, marked": Operation(work=lambda folder: extract(folder, "marked.obj"), bars=(0.3, None)),
    "authenticate": Operation(work=authenticate, bars=(1.0, 3.0)),
    "extract, not marked (quick)": Operation(
        work=lambda folder: extract(folder, "plain.obj"), bars=(2.0, 6.0)
    ),
}


@dataclass(frozen=True, kw_only=True)
class Cost:
    """seconds: user and system time of the operation; whole: of its process; memory: peak, in GB."""

    seconds: float
    whole: float
    memory: float


def used() -> float:
    """User and system seconds of this process and of those it waited for so far."""
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in both)


def run(name: str, folder: str) -> None:
    """Run one operation and print its seconds, those of the whole process, and its peak memory in GB."""
    before = used()
    OPERATIONS[name].work(Path(folder))
    print(used() - before, used(), peak())


def peak() -> float:
    """Return the most GB that this process has taken, or that a process of its own has, whichever is more."""
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return max(usage.ru_maxrss for usage in both) / 2**20


def measured(name: str, folder: Path) -> Cost:
    """Return what an operation costs in a process of its own."""
    # As the product runs: meshmark says which code of the linear algebra library is taken before NumPy is imported.
    code = f"import meshmark; from claims.performance import run; run({name!r}, {str(folder)!r})"
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, stdout=subprocess.PIPE, text=True, env=os.environ | one
    )
    seconds, whole, memory = map(float, done.stdout.split())
    return Cost(seconds=seconds, whole=whole, memory=memory)


def subdivided(size: int) -> Mesh:
    """Return a training model subdivided to about `size` points, with a smooth relief."""
    import trimesh

    name, times = SOURCES[size]
    plain = weld(load(DATA / name))
    surface = trimesh.Trimesh(plain.points, plain.faces, process=False)
    if times:
        surface = surface.subdivide_loop(times)
    points = np.asarray(surface.vertices)
    extent, rng = float(np.ptp(points, axis=0).max()), np.random.default_rng(0)
    waves = rng.normal(size=(30, 3)) * 60.0 / extent
    height = np.sin(points @ waves.T + rng.uniform(0.0, 2.0 * np.pi, 30)).mean(axis=1)
    relief = points + 1e-3 * extent * height[:, None] * np.asarray(surface.vertex_normals)
    return Mesh(relief, np.asarray(surface.faces, np.int64))


def report(mesh: Mesh, folder: Path, repeats: int) -> bool:
    """Measure one model, print its rows, and return whether each is within its bar."""
    write_mesh(mesh, folder / "plain.obj")
    count, good = len(mesh.vertices), True
    runs: dict[str, list[tuple[Cost, float]]] = {}
    for _ in range(repeats):
        before = measured(TRIMESH, folder)
        costs = {name: measured(name, folder) for name in OPERATIONS if name != TRIMESH}
        beside = (before.seconds + measured(TRIMESH, folder).seconds) / 2.0
        for name, cost in {TRIMESH: before, **costs}.items():
            runs.setdefault(name, []).append((cost, cost.seconds / beside))
    for name, some in runs.items():
        cost = Cost(**{each: median(getattr(one, each) for one, _ in some) for each in Cost.__annotations__})
        ratio, bars = median(each for _, each in some), OPERATIONS[name].bars
        bar = bars[1] if count >= LARGE else bars[0] if count >= 20_000 else None
        missed = bar is not None and ratio > bar
        missed |= count >= LARGE and name != TRIMESH and cost.memory > MEMORY
        missed |= count <= 5_500 and name == "embed both, miniature" and cost.whole > COLD
        good = good and not missed
        cells = [f"{count:,}", name, f"{cost.seconds:.2f}", f"{ratio:.2f}", "" if bar is None else f"{bar:g}"]
        cells += [f"{cost.whole:.2f}", f"{cost.memory:.2f}", "missed" if missed else ""]
        print("|", " | ".join(cells), "|", flush=True)
    return good


def profile(name: str, folder: Path) -> None:
    """Print the functions that take most of one operation's time."""
    import cProfile
    import pstats

    if "marked" in name or name == "authenticate":
        measured("embed both, miniature", folder)
    watch = cProfile.Profile()
    watch.runcall(OPERATIONS[name].work, folder)
    pstats.Stats(watch).strip_dirs().sort_stats("cumulative").print_stats(60)


def main() -> int:
    """Measure and print; exit 1 where a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("models", nargs="*", type=Path)
    parser.add_argument("--sizes", nargs="+", type=int, choices=SOURCES, default=list(SOURCES))
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--profile", choices=OPERATIONS)
    options = parser.parse_args()
    good = True
    if options.profile is None:
        print("| points | operation | seconds | ratio | bar | whole process, s | peak, GB | |")
        print("|---|---|---|---|---|---|---|---|")
    for one in options.models or options.sizes:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            mesh = subdivided(one) if isinstance(one, int) else load(one)
            if options.profile is None:
                good = report(mesh, folder, options.repeats) and good
            else:
                write_mesh(mesh, folder / "plain.obj")
                profile(options.profile, folder)
    return int(not good)


if __name__ == "__main__":
    sys.exit(main())
