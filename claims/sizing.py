"""What a million models cost: `python -m claims.sizing ROWS.csv`.

[--split train] [--each 3] [--minutes M] [--models 1000000] [--tables]

Of each size class some models, spread over it, are marked, read and authenticated by the single commands in one
process: processor seconds, bytes of the model, of the marked copy with its certificate and of the line of results.
A row is written as soon as its model is done; run it again to continue. Then a million models are simulated: drawn
from the rows by the shares of a collection, handed to the workers that become free first; the time until the last
is done is printed for several numbers of cores.

Figures of docs/sizing.md.
"""

from __future__ import annotations

import contextlib
import csv
import heapq
import io
import json
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from time import process_time

import numpy as np

from claims.models import DATA, SIZE_CLASSES, load, model_paths, size_class
from claims.resumable import Row, measure, parser_of
from meshmark.cli.main import main as meshmark
from meshmark.coding.keys import Key
from meshmark.io import write_mesh
from meshmark.mesh import FloatArray
from meshmark.research.benchmark.run.model_files import size_class as size_class_of

COMMANDS = ("embed", "extract", "authenticate")
CLASSES = tuple(name for _, name in SIZE_CLASSES)
COLUMNS = ("model", "size_class", *COMMANDS, "model_bytes", "copy_bytes", "line_bytes", "seconds")
COLLECTIONS = {
    "small parts (Princeton)": (0.20, 0.37, 0.15, 0.25, 0.03),
    "assets of a studio": (0.05, 0.20, 0.20, 0.35, 0.20),
    "scans": (0.0, 0.0, 0.05, 0.25, 0.70),
}
"""Shares of the size classes, smallest first."""
CORES = (2, 16, 64, 256)
START = 1.5
"""Processor seconds until a worker is ready."""


def row_of(model: str) -> Row:
    """Return the row of a model, its path relative to the data."""
    mesh = load(DATA / model)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        source, copy, key = folder / "in.ply", folder / "out.ply", folder / "my.key"
        write_mesh(mesh, source)
        Key(bytes(range(32))).save(key)
        row = {"model": model, "size_class": size_class(mesh), "model_bytes": str(source.stat().st_size)}
        lines = {
            "embed": ["embed", source, copy, "--certificate", folder / "out.cert"],
            "extract": ["extract", copy],
            "authenticate": ["authenticate", copy],
        }
        for command, line in lines.items():
            said, start = io.StringIO(), process_time()
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(io.StringIO()):
                code = meshmark([*map(str, line), "--key", str(key), "--json"])
            row[command] = f"{process_time() - start:.3f}"
            row["seconds"] = row[command]
            if command == "embed":
                row["line_bytes"] = str(len(said.getvalue()))
            if code in (2, 4):  # it cannot be marked: the cost of being refused
                json.loads(said.getvalue())
                break
        kept = (copy, folder / "out.cert")
        row["copy_bytes"] = str(sum(path.stat().st_size for path in kept if path.exists()))
    return row


def chosen(split: str, each: int) -> list[str]:
    """Return `each` models of each size class, spread over it by their points."""
    with (DATA / "MANIFEST.tsv").open(encoding="utf-8") as file:
        rows = csv.DictReader(file, delimiter="\t")
        points = {row["path"]: int(row["points"]) for row in rows if row["points"]}
    found: dict[str, list[str]] = {}
    for folder in (f"models/{split}", f"psb/{split}"):
        for path in model_paths(folder):
            name = path.relative_to(DATA).as_posix()
            if name in points:
                found.setdefault(size_class_of(points[name]), []).append(name)
    picked = []
    for names in found.values():
        names.sort(key=lambda name: points[name])
        places = np.linspace(0, len(names) - 1, min(each, len(names)) + 2)[1:-1].round().astype(int)
        picked += [names[place] for place in places]
    return sorted(picked, key=lambda name: points[name])


def makespan(work: Iterable[float], cores: int) -> float:
    """Return the seconds until workers, each given the next piece when it is free, have done all."""
    free = [START] * cores
    for piece in work:
        heapq.heapreplace(free, free[0] + piece)
    return max(free)


def simulated(rows: list[Row], shares: tuple[float, ...], count: int, what: str) -> FloatArray:
    """Return the cost of `count` models drawn by these shares of the size classes."""
    rng, drawn = np.random.default_rng(0), []
    for share, name in zip(shares, CLASSES, strict=True):
        known = [float(row[what]) for row in rows if row["size_class"] == name and row[what]]
        if share and known:
            drawn.append(rng.choice(known, round(share * count)))
    return np.asarray(rng.permutation(np.concatenate(drawn)))


def report(rows: list[Row], count: int) -> None:
    print(
        "| size class | models | "
        + " | ".join(f"{each}, s" for each in COMMANDS)
        + " | model | copy + certificate |"
    )
    print("|---|---|" + "---|" * (len(COMMANDS) + 2))
    for name in CLASSES:
        some = [row for row in rows if row["size_class"] == name]
        cells = [name, str(len(some))]
        for command in COMMANDS:
            known = [float(row[command]) for row in some if row[command]]
            cells.append(f"{np.mean(known):.2f} ({max(known):.2f})" if known else "")
        for size in ("model_bytes", "copy_bytes"):
            cells.append(f"{np.mean([float(row[size]) for row in some]) / 1e3:,.0f} kB" if some else "")
        print("|", " | ".join(cells), "|")
    print(f"\nA million = {count:,} models, hours:\n")
    print(
        "| collection | command | work, core hours | "
        + " | ".join(f"{each} cores" for each in CORES)
        + " | copies |"
    )
    print("|---|---|---|" + "---|" * (len(CORES) + 1))
    for collection, shares in COLLECTIONS.items():
        size = simulated(rows, shares, count, "copy_bytes").sum() / 1e9
        for command in COMMANDS:
            work = simulated(rows, shares, count, command)
            spans = [makespan(work.tolist(), cores) / 3600 for cores in CORES]
            cells = [collection, command, f"{work.sum() / 3600:,.0f}", *(f"{span:,.1f}" for span in spans)]
            print("|", " | ".join([*cells, f"{size:,.0f} GB" if command == "embed" else ""]), "|")


def main() -> int:
    """Measure, simulate and print."""
    parser = parser_of(__doc__, 0)
    parser.add_argument("--each", type=int, default=3)
    parser.add_argument("--models", type=int, default=1_000_000)
    options = parser.parse_args()
    rows = measure(options, COLUMNS, chosen(options.split, options.each), row_of)
    report(rows, options.models)
    return 0


if __name__ == "__main__":
    sys.exit(main())
