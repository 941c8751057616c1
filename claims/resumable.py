"""A claim that measures model by model, writes a row as soon as one is done, and continues an interrupted run."""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from time import monotonic

from claims.models import DATA, load
from claims.princeton import read_rows
from meshmark.errors import MeshmarkError
from meshmark.geometry.surface_of import surface_of

__all__ = ["measure", "parser_of"]

Row = dict[str, str]


def parser_of(description: str | None, least: int) -> argparse.ArgumentParser:
    """Return what the command line of such a claim has; least: fewest welded points of a model, by default."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("rows", type=Path)
    parser.add_argument("--split", default="test", choices=["train", "test"])
    parser.add_argument("--limit", type=int)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    parser.add_argument("--least", type=int, default=least)
    parser.add_argument("--tables", action="store_true")
    return parser


def measure(
    options: argparse.Namespace, columns: Sequence[str], models: Iterable[str], row_of: Callable[[str], Row]
) -> list[Row]:
    """Measure the models (relative to the data) that have no row yet, and return all rows; none with --tables."""
    known = {row["model"] for row in read_rows(options.rows)}
    end = monotonic() + 60.0 * options.minutes
    fresh = not options.rows.exists() or not options.rows.stat().st_size
    with options.rows.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, restval="")
        if fresh:
            writer.writeheader()
        for model in list(models)[: options.limit] if not options.tables else ():
            if model in known or monotonic() > end:
                continue
            try:
                if len(surface_of(load(DATA / model)).points) < options.least:
                    continue
                writer.writerow(row_of(model))
            except MeshmarkError as error:
                print(f"{model}: {error}", file=sys.stderr)
            file.flush()
    return read_rows(options.rows)
