"""Which search strategy tells the ids of damaged copies, and what each costs where there is no mark.

python -m claims.search_use ROWS.csv [--split train] [--limit N] [--minutes M] [--least 200] [--tables]

Each model gets an id alone, is damaged by each of `CHANGES` and turned, and is read blind, strategy by strategy, as
a quick search does. Of the first reading that tells the id the row holds the strategy, the number of the reading
there, log10 of the chance of its lock and the bound of the answer. The unmarked model is read by all strategies,
whose processor seconds the row holds. A row is written as soon as its model is done; run it again to continue.

Figures of docs/decisions/0044-absent-of-small-models.md.
"""

from __future__ import annotations

import hashlib
import sys
from collections import Counter
from collections.abc import Iterator
from statistics import median
from time import process_time

import numpy as np

from claims.models import DATA, SIZE_CLASSES, load, size_class
from claims.princeton import models_of
from claims.resumable import measure, parser_of
from meshmark.attacks import parse_chain
from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, MeshmarkError
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.decoding import Found, Listed, decoded
from meshmark.ownership.embedding import embed
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.strategies import STRATEGIES, Strategy

CHANGES = (
    "noise:0.001",
    "noise:0.005",
    "noise:0.01",
    "quantisation:12",
    "quantisation:8",
    "quantisation:7",
    "smoothing:8",
    "smoothing:10",
    "smoothing:50",
    "smoothing_half:3",
    "smoothing_half:10",
    "taubin:10",
    "noise:0.003+smoothing:5",
    "smoothing:10+noise:0.001",
    "simplification:0.5+noise:0.003",
    "simplification:0.9",
    "midpoint:1",
    "mirror:1",
    "affine:0.01",
    "crop:0.06",
)
NAMES = tuple(strategy.name for strategy in STRATEGIES)
COLUMNS = ("model", "size_class", "outcome", *CHANGES, *NAMES, "seconds")
WRONG = "wrong id"


def readings(search: Search) -> Iterator[tuple[Strategy, int, float, Found | None]]:
    """Yield strategy, number of the reading there, log10 of the chance of its lock, and what is decoded."""
    codec = Codec(search.key)
    listed = Listed(ids=(), words=codec.words(()))
    for strategy in STRATEGIES:
        for number, reading in enumerate(
            strategy.readings(search) if strategy.applies(search) else (), start=1
        ):
            limit = strategy.decode_below
            found = None
            if limit is None or reading.log10_chance <= limit:
                found = decoded(codec, reading, listed, search.trials.charge_decoding())
            yield strategy, number, reading.log10_chance, found


def told(mesh: Mesh, key: Key, identity: int) -> str:
    """Return which reading tells the id, "" where none does."""
    for strategy, number, chance, found in readings(Search(surface=surface_of(mesh), key=key)):
        if found is not None and found.ids:
            if found.id != identity:
                return WRONG
            return f"{strategy.name};{number};{chance:.2f};{found.log10_false_positive:.1f}"
    return ""


def costs(mesh: Mesh, key: Key) -> dict[str, str]:
    """Return the processor seconds of each strategy on a model without a mark."""
    search, seconds = Search(surface=surface_of(mesh), key=key), {}
    codec = Codec(key)
    listed = Listed(ids=(), words=codec.words(()))
    for strategy in STRATEGIES:
        begun = process_time()
        for reading in strategy.readings(search) if strategy.applies(search) else ():
            limit = strategy.decode_below
            if limit is None or reading.log10_chance <= limit:
                decoded(codec, reading, listed, search.trials.charge_decoding())
        seconds[strategy.name] = f"{process_time() - begun:.3f}"
    return seconds


def row_of(model: str) -> dict[str, str]:
    """Return the row of one model."""
    start = process_time()
    mesh = load(DATA / model)
    digest = hashlib.sha256(model.encode()).digest()
    key, identity = Key(digest), int.from_bytes(digest[:8], "little")
    row = {"model": model, "size_class": size_class(mesh)} | costs(mesh, key)
    try:
        made = embed(mesh, key, id=identity)
    except CapacityError as error:
        return row | {"outcome": f"refused: {error}", "seconds": f"{process_time() - start:.2f}"}
    row["outcome"] = "points" if made.mark.at_points else "cells"
    for change in CHANGES:
        seed = hashlib.sha256(f"{model} {change}".encode()).digest()[:8]
        random = np.random.default_rng(int.from_bytes(seed))
        try:
            row[change] = told(parse_chain(f"{change}+similarity:1")(made.mesh, random), key, identity)
        except MeshmarkError as error:
            row[change] = f"refused: {error}"
    return row | {"seconds": f"{process_time() - start:.2f}"}


def main() -> int:
    """Measure, print, and exit with 1 where a wrong id was told."""
    parser = parser_of(__doc__, least=200)
    parser.set_defaults(split="train")
    options = parser.parse_args()
    rows = measure(options, COLUMNS, models_of([options.split]), row_of)
    print("| damage | cells, told | at points, told | by |\n|---|---|---|---|")
    for change in CHANGES:
        by: Counter[str] = Counter(row[change].split(";")[0] for row in rows if ";" in row[change])
        cells = [
            f"{sum(';' in row[change] for row in some)} of {len(some)}"
            for some in ([row for row in rows if row["outcome"] == kind] for kind in ("cells", "points"))
        ]
        print(
            f"| {change} | {' | '.join(cells)} | {', '.join(f'{name} {n}' for name, n in by.most_common())} |"
        )
    print(f"\n| not marked, median seconds | {' | '.join(NAMES)} |\n|---|{'---|' * len(NAMES)}")
    for _, name in SIZE_CLASSES:
        some = [row for row in rows if row["size_class"] == name]
        if some:
            seconds = (f"{median(float(row[each]) for row in some):.2f}" for each in NAMES)
            print(f"| {name}: {len(some)} | " + " | ".join(seconds) + " |")
    return int(any(row[change] == WRONG for row in rows for change in CHANGES))


if __name__ == "__main__":
    sys.exit(main())
