"""Extractions that must find nothing: unmarked models under random keys, marked models under wrong keys.

python -m claims.false_positives [--trials 2000] [--workers 2] [--folders models/test psb/test] [--plot SVG]

After --minutes M no further model is begun; the table is of the trials made until then.

Figures of docs/results/false-positives.md.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path
from time import monotonic

import numpy as np

from claims.models import load, model_paths
from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.marking import embed, extract
from meshmark.mesh import Mesh
from meshmark.research.benchmark.page.calibration import calibration_panel
from meshmark.research.benchmark.page.report_parts import Entry


def run_model(path: Path, trials: int, most_points: int, end: float) -> list[tuple[str, str, float]]:
    """Return (kind, presence, log10 bound) of each trial on one model: half unmarked, half marked."""
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
        found = extract(suspect, Key(random.bytes(32)))
        rows.append((kind, found.presence, found.log10_false_positive))
    return rows


def main() -> int:
    """Run and print; exit 1 where anything was found present."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folders", nargs="+", default=["models/test", "psb/test"])
    parser.add_argument("--trials", type=int, default=2000)
    parser.add_argument("--most-points", type=int, default=10**9, help="leave larger models out")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    parser.add_argument("--plot", type=Path, help="draw the share of bounds at or below p against p")
    arguments = parser.parse_args()
    paths = list(model_paths(*arguments.folders))
    end = monotonic() + 60.0 * arguments.minutes
    each = -(-arguments.trials // len(paths)) + 1
    with ProcessPoolExecutor(arguments.workers) as pool:
        rows = []
        for path, part in zip(
            paths,
            pool.map(run_model, paths, repeat(each), repeat(arguments.most_points), repeat(end)),
            strict=True,
        ):
            rows += part
            present = sum(row[1] == "present" for row in part)
            if part:
                print(f"{path.name.split('.')[0]:32s} {len(part):4d} trials, {present} present", flush=True)
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
