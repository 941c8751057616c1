"""Models that nobody altered: marked with each choice of layers and tolerance, then put through what is promised.

python -m claims.false_alarms --store FILE.csv [--models models/test psb/test:100 textured] [--workers 2]
    [--written]

One row a model, layers and tolerance; rows that are in the store are not made again, so a run that was stopped
goes on. psb/test:100 stands for a seeded 100 of that folder. After --minutes M no further row is begun.
Prints a table of trials and alarms with 95 % upper bounds; exits 1 where there was an alarm.

Figures of docs/decisions/0008-authentication-marks.md.
"""

from __future__ import annotations

import argparse
import csv
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, fields
from itertools import islice, product
from pathlib import Path
from time import monotonic, perf_counter
from zlib import crc32

import numpy as np

import meshmark as mm
from claims.benign import written_and_promised
from claims.models import DATA, load
from meshmark.errors import CapacityError, MeshmarkError
from meshmark.mesh import Mesh
from meshmark.research.benchmark.figures.intervals import upper_limit

KEY = mm.Key(bytes(range(32)))
LAYERS = ("both", "ownership", "authentication")
TOLERANCES = ("strict", "default", "tolerant")
# The id alone has no tolerance.
NONE = "none"
MODELS = ("models/test", "psb/test:100", "textured")
ENDINGS = (".xz", ".glb", ".gltf", ".obj", ".ply", ".off", ".stl", ".3mf")


@dataclass(frozen=True, kw_only=True)
class Row:
    """What became of a model with these layers and this tolerance.

    outcome: "marked", "refused" (for want of room), or "failed" (any other error). trials: operations, the plain
    file included; alarms: those after which the model was called altered; alarmed: their names. said: the refusal,
    or remarks.
    """

    model: str
    layers: str
    tolerance: str
    points: int
    outcome: str
    trials: int
    alarms: int
    alarmed: str
    said: str
    seconds: float


def models_of(names: Iterable[str]) -> list[Path]:
    """Return the model files of folders of the data, in a seeded order; `folder:n` is a seeded n of its files."""
    paths = []
    for name in names:
        folder, _, count = name.partition(":")
        found = sorted(path for path in (DATA / folder).iterdir() if path.suffix in ENDINGS)
        if count:
            drawn = np.random.default_rng(crc32(folder.encode())).permutation(len(found))[: int(count)]
            found = [found[each] for each in drawn]
        paths += found
    return [paths[each] for each in np.random.default_rng(14).permutation(len(paths))]


def measure(path: Path, layers: str, tolerance: str, most: int | None = None) -> Row:
    """Mark a model and put the file through operations that are promised to leave it authentic.

    most: how many of them, the file as written first; None: all.
    """
    start, model = perf_counter(), path.relative_to(DATA).as_posix()
    points, trials, alarmed = 0, 0, []
    outcome, said = "marked", ""
    try:
        mesh = load(path) if path.suffix == ".xz" else mm.read_mesh(path)
        points = len(mesh.vertices)
        marked = mm.embed(
            mesh,
            KEY,
            id=crc32(model.encode()),
            layers=layers,
            tolerance=None if tolerance == NONE else tolerance,
        )
        said = "; ".join(marked.remarks)
        with tempfile.TemporaryDirectory(prefix="meshmark-") as folder:
            for name, changed in islice(written_and_promised(marked, path, tolerance, Path(folder)), most):
                trials += 1
                if raises_alarm(changed, marked.id, layers):
                    alarmed.append(name)
    except CapacityError as error:
        outcome, said = "refused", str(error)
    except MeshmarkError as error:
        outcome, said = "failed", str(error)
    except Exception as error:  # a crash is a row, too
        outcome, said = "failed", f"{type(error).__name__}: {error}"
    return Row(
        model=model,
        layers=layers,
        tolerance=tolerance,
        points=points,
        outcome=outcome,
        trials=trials,
        alarms=len(alarmed),
        alarmed=" ".join(alarmed),
        said=said,
        seconds=round(perf_counter() - start, 1),
    )


def raises_alarm(mesh: Mesh, identity: int, layers: str) -> bool:
    """Return whether a model that is as it was is called anything but that: with the id alone, called altered."""
    found = mm.authenticate(mesh, KEY)
    if layers == "ownership":
        return found.verdict == "altered"
    return found.verdict != "authentic" or found.id != identity


def main() -> int:
    """Run what is not in the store yet, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--store", type=Path, required=True, help="CSV file of rows; made where there is none"
    )
    parser.add_argument("--models", nargs="+", default=list(MODELS), metavar="FOLDER[:N]")
    parser.add_argument("--layers", nargs="+", choices=LAYERS, default=list(LAYERS))
    parser.add_argument("--tolerances", nargs="+", choices=TOLERANCES, default=list(TOLERANCES))
    parser.add_argument("--most-bytes", type=int, default=10**12, help="leave larger files out")
    parser.add_argument("--written", action="store_true", help="only the file as written, no operation")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    options = parser.parse_args()
    paths = [path for path in models_of(options.models) if path.stat().st_size <= options.most_bytes]
    wanted = [job for path in paths for job in _jobs(path, options.layers, options.tolerances)]
    rows = read_rows(options.store)
    done = {(row.model, row.layers, row.tolerance) for row in rows}
    jobs = [job for job in wanted if (job[0].relative_to(DATA).as_posix(), *job[1:]) not in done]
    print(f"{len(wanted)} rows wanted, {len(jobs)} to make", flush=True)
    most = 1 if options.written else None
    for row in _made(jobs, most, options.workers, monotonic() + 60.0 * options.minutes):
        append(options.store, row)
        rows.append(row)
        print(
            f"{row.model} {row.layers} {row.tolerance}: {row.outcome}, {row.trials} trials, {row.alarms} alarms "
            f"{row.alarmed} {row.seconds} s {row.said}",
            flush=True,
        )
    print(table(rows))
    return int(any(row.alarms or row.outcome == "failed" for row in rows))


def _jobs(path: Path, layers: list[str], tolerances: list[str]) -> Iterator[tuple[Path, str, str]]:
    for layer, tolerance in product(layers, tolerances):
        if layer != "ownership":
            yield path, layer, tolerance
    if "ownership" in layers:
        yield path, "ownership", NONE


def _made(jobs: list[tuple[Path, str, str]], most: int | None, workers: int, end: float) -> Iterator[Row]:
    """Yield rows as they are made; none is begun after `end`."""
    if workers <= 1:
        for job in jobs:
            if monotonic() > end:
                return
            yield measure(*job, most)
        return
    with ProcessPoolExecutor(workers) as pool:
        waiting = {pool.submit(_before, end, most, *job) for job in jobs}
        for ready in as_completed(waiting):
            if (row := ready.result()) is not None:
                yield row


def _before(end: float, most: int | None, path: Path, layers: str, tolerance: str) -> Row | None:
    return measure(path, layers, tolerance, most) if monotonic() <= end else None


def read_rows(store: Path) -> list[Row]:
    """Return the rows of a store, none where there is no such file."""
    if not store.exists():
        return []
    with store.open(newline="", encoding="utf-8") as file:
        kinds = {"points": int, "trials": int, "alarms": int, "seconds": float}
        return [
            Row(**{name: kinds.get(name, str)(value) for name, value in line.items()})
            for line in csv.DictReader(file)
        ]


def append(store: Path, row: Row) -> None:
    """Add a row to a store."""
    new = not store.exists()
    with store.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Row)])
        if new:
            writer.writeheader()
        writer.writerow(asdict(row))


def table(rows: list[Row]) -> str:
    """Return a Markdown table of alarms, by layers and tolerance, and by what was done where there were any."""
    groups: dict[tuple[str, str], list[Row]] = defaultdict(list)
    for row in rows:
        groups[row.layers, row.tolerance].append(row)
    lines = [
        "| layers | tolerance | marked | refused | failed | trials | alarms | at most (95 %) | rows with alarms |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for names, part in [*sorted(groups.items()), (("all", ""), rows)]:
        count = {kind: sum(row.outcome == kind for row in part) for kind in ("marked", "refused", "failed")}
        trials, alarms = sum(row.trials for row in part), sum(row.alarms for row in part)
        hit = sum(row.alarms > 0 for row in part)
        cells = [*names, *count.values(), trials, alarms, f"{upper_limit(alarms, trials):.2%}", hit]
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    after: dict[str, int] = defaultdict(int)
    for row in rows:
        for name in row.alarmed.split():
            after[name] += 1
    lines += [f"alarms after {name}: {count}" for name, count in sorted(after.items())]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
