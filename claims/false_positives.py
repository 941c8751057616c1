"""Extractions that must find nothing: unmarked models under random keys, marked models under wrong keys.

python -m claims.false_positives ROWS.csv [--trials 3000] [--workers 2] [--folders models/test psb/test]

Each trial is a row of ROWS.csv, written model by model; the same command goes on with the models that have none.
After --minutes M no further model is begun; the table is of all rows there are.

Figures of docs/results/false-positives.md.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import hashlib
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path
from time import monotonic, process_time

import numpy as np

from claims.models import DATA, load, model_paths
from claims.princeton import read_rows
from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.marking import embed, extract
from meshmark.mesh import Mesh
from meshmark.research.benchmark.page.calibration import calibration_panel
from meshmark.research.benchmark.page.report_parts import Entry


def run_model(path: Path, trials: int, most_points: int, end: float) -> list[tuple[str, str, float, float]]:
    """Return (kind, presence, log10 bound, processor seconds) of each trial on one model, half of them marked."""
    if monotonic() > end:
        return []
    seed = hashlib.sha256(path.name.encode()).digest()
    random = np.random.default_rng(int.from_bytes(seed[:8], "big"))
    try:
        mesh = load(path)
    except MeshmarkError:
        return []
    if len(mesh.vertices) > most_points:
        return []
    marked: Mesh | None = None
    with contextlib.suppress(MeshmarkError):  # refused: all its trials are of the unmarked model
        marked = embed(mesh, Key(random.bytes(32)), id=1, layers="ownership").mesh
    rows = []
    for trial in range(trials):
        kind, suspect = ("wrong key", marked) if trial % 2 and marked is not None else ("unmarked", mesh)
        start = process_time()
        found = extract(suspect, Key(random.bytes(32)))
        seconds = round(process_time() - start, 2)
        rows.append((kind, found.presence, found.log10_false_positive, seconds))
    return rows


def measure(arguments: argparse.Namespace, paths: list[Path], trials: int) -> None:
    """Make the trials of the models that have no rows yet, and write these, model by model."""
    known = {row["model"] for row in read_rows(arguments.rows)}
    left = [path for path in paths if path.relative_to(DATA).as_posix() not in known]
    end = monotonic() + 60.0 * arguments.minutes
    fresh = not arguments.rows.exists() or not arguments.rows.stat().st_size
    with (
        arguments.rows.open("a", newline="", encoding="utf-8") as file,
        ProcessPoolExecutor(arguments.workers) as pool,
    ):
        writer = csv.writer(file)
        if fresh:
            writer.writerow(["model", "kind", "presence", "log10_bound", "seconds"])
        made = pool.map(run_model, left, repeat(trials), repeat(arguments.most_points), repeat(end))
        for path, part in zip(left, made, strict=True):
            writer.writerows([path.relative_to(DATA).as_posix(), *row] for row in part)
            file.flush()
            present = sum(row[1] == "present" for row in part)
            if part:
                print(f"{path.name.split('.')[0]:32s} {len(part):4d} trials, {present} present", flush=True)


def main() -> int:
    """Run and print; exit 1 where anything was found present."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", type=Path)
    parser.add_argument("--folders", nargs="+", default=["models/test", "psb/test"])
    parser.add_argument("--trials", type=int, default=3000)
    parser.add_argument("--most-points", type=int, default=10**9, help="leave larger models out")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    parser.add_argument("--plot", type=Path, help="draw the share of bounds at or below p against p")
    arguments = parser.parse_args()
    paths = list(model_paths(*arguments.folders))
    each = -(-arguments.trials // len(paths)) + 1
    measure(arguments, paths, each)
    rows = [(row["kind"], row["presence"], float(row["log10_bound"])) for row in read_rows(arguments.rows)]
    if not rows:
        print("no trials")
        return 1
    for (kind, presence), count in sorted(Counter(row[:2] for row in rows).items()):
        print(f"{kind:10s} {presence:13s} {count}")
    bounds = np.sort([row[2] for row in rows])
    print(f"{len(rows)} trials; smallest log10 bounds {np.round(bounds[:5], 2)}")
    for level in (-1.0, -2.0, -3.0):
        print(f"share with a bound below 10^{level:.0f}: {np.mean(bounds < level):.5f}")
    if arguments.plot:
        kinds = sorted({row[0] for row in rows})
        samples = [np.array([row[2] for row in rows if row[0] == kind]) for kind in kinds]
        entries = [Entry(words=kind, colour=i) for i, kind in enumerate(kinds)]
        arguments.plot.write_text(calibration_panel(entries, samples).svg, encoding="utf-8")
    present = sum(row[1] == "present" for row in rows)
    print(f"present: {present} (95 % upper bound of the rate {3.0 / len(rows):.1e} where 0)")
    return int(present > 0)


if __name__ == "__main__":
    sys.exit(main())
