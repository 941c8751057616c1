"""What `embed` makes of every model of the Princeton Shape Benchmark: marked, refused and why, or crashed.

python -m claims.princeton ROWS.csv [--splits train test] [--workers 1] [--limit N] [--seconds 600] [--tables]

Each model is marked with the default options and a key of its own, in a process of its own with a time limit. A
row is written as soon as its model is done; run it again to continue an interrupted run. The models come in an
order in which any first few are spread over sizes. At the end, or at once with --tables, two tables are printed:
outcomes by size class, and reasons of the models that were not marked with both layers.

Figures of docs/results/field-files.md.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import re
import traceback
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from hashlib import blake2b
from multiprocessing.connection import Connection
from pathlib import Path
from time import perf_counter

from claims.models import DATA, SIZE_CLASSES, load, size_class
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, MeshmarkError
from meshmark.marking import embed
from meshmark.research.benchmark.run.model_files import find_models, spread

COLUMNS = ("model", "size_class", "outcome", "reason", "payload_bytes", "seconds")
OUTCOMES = ("both", "ownership", "refused", "unreadable", "timeout", "crash")
"""Layers that were embedded, or what happened instead; "unreadable": the file is refused, not the mark."""
_CONTEXT = multiprocessing.get_context("forkserver")


def mark(model: str, answer: Connection) -> None:
    """Send the row of one model, without its seconds."""
    row = {"model": model, "size_class": "", "reason": "", "payload_bytes": "0"}
    try:
        mesh = load(DATA / model)
        row["size_class"] = size_class(mesh)
        digest = blake2b(model.encode(), digest_size=40).digest()
        made = embed(mesh, Key(digest[:32]), id=int.from_bytes(digest[32:], "little"))
        row |= {
            "outcome": made.layers,
            "reason": " ".join(made.remarks),
            "payload_bytes": str(made.payload_bytes),
        }
    except CapacityError as error:
        row |= {"outcome": "refused", "reason": str(error)}
    except MeshmarkError as error:
        row |= {"outcome": "unreadable", "reason": str(error)}
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        row |= {
            "outcome": "crash",
            "reason": f"{type(error).__name__} in {Path(place.filename).name}, {place.name}: {error}",
        }
    answer.send(row)


def marked(model: str, seconds: float) -> dict[str, str]:
    """Return the row of one model, marked in a process of its own."""
    start = perf_counter()
    ours, theirs = _CONTEXT.Pipe(duplex=False)
    process = _CONTEXT.Process(target=mark, args=(model, theirs))
    process.start()
    theirs.close()
    row = {"model": model, "size_class": "", "payload_bytes": "0"}
    try:
        if ours.poll(seconds):
            row = ours.recv()
        else:
            row |= {"outcome": "timeout", "reason": f"not done after {seconds:g} seconds"}
    except EOFError:
        process.join()
        row |= {"outcome": "crash", "reason": f"the process ended with code {process.exitcode}"}
    process.kill()
    process.join()
    if not row["size_class"]:
        row["size_class"] = _size_class(model)
    return row | {"seconds": f"{perf_counter() - start:.2f}"}


def _size_class(model: str) -> str:
    try:
        return size_class(load(DATA / model))
    except MeshmarkError:
        return ""


def read_rows(path: Path) -> list[dict[str, str]]:
    """Return the rows of an earlier run, none where there is no file."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["seconds"]]


def run(path: Path, models: Iterable[str], workers: int, seconds: float) -> None:
    """Mark the models and append their rows."""
    fresh = not path.exists() or not path.stat().st_size
    with path.open("a", newline="", encoding="utf-8") as file, ThreadPoolExecutor(workers) as pool:
        writer = csv.DictWriter(file, COLUMNS)
        if fresh:
            writer.writeheader()
        for done in as_completed([pool.submit(marked, model, seconds) for model in models]):
            writer.writerow(done.result())
            file.flush()


def models_of(splits: Iterable[str]) -> Iterator[str]:
    """Yield the models of these splits, relative to the data."""
    for split in splits:
        folder = DATA / "psb" / split
        yield from (f"psb/{split}/{model}" for model in spread(folder, find_models(folder)))


def tables(rows: list[dict[str, str]]) -> str:
    """Return outcomes by size class, and the reasons of what was not marked with both layers, as Markdown."""
    names = [name for _, name in SIZE_CLASSES]
    lines = [f"| points | models | {' | '.join(OUTCOMES)} |", f"|---|{'---|' * (len(OUTCOMES) + 1)}"]
    for name in [*names, "all"]:
        own = [row for row in rows if name in ("all", row["size_class"])]
        count = Counter(row["outcome"] for row in own)
        lines.append(f"| {name} | {len(own)} | {' | '.join(str(count[each]) for each in OUTCOMES)} |")
    reasons = Counter((row["outcome"], _without_numbers(row["reason"])) for row in rows if row["reason"])
    lines += ["", "| models | outcome | reason |", "|---|---|---|"]
    lines += [f"| {count} | {outcome} | {reason} |" for (outcome, reason), count in reasons.most_common()]
    return "\n".join(lines)


def _without_numbers(text: str) -> str:
    return re.sub(r"\d[\d,.]*(?<=\d)", "N", text)


def main() -> None:
    """Mark what is not marked yet, and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("rows", type=Path)
    parser.add_argument("--splits", nargs="+", choices=("train", "test"), default=["train", "test"])
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--limit", type=int, help="models of each run, those of earlier runs not counted")
    parser.add_argument("--seconds", type=float, default=600.0, help="time limit of each model")
    parser.add_argument("--tables", action="store_true", help="print the tables of the rows that are there")
    given = parser.parse_args()
    if not given.tables:
        done = {row["model"] for row in read_rows(given.rows)}
        left = [model for model in models_of(given.splits) if model not in done]
        _CONTEXT.set_forkserver_preload(["claims.models", "meshmark.marking"])
        run(given.rows, left[: given.limit], given.workers, given.seconds)
    print(tables(read_rows(given.rows)))


if __name__ == "__main__":
    main()
