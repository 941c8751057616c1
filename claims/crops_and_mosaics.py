"""Whether crops, and mosaics of two copies, name the ids they carry, by the key alone.

python -m claims.crops_and_mosaics ROWS.csv [--split test] [--limit N] [--minutes M] [--least 2500]
    [--marked-only] [--tables]

Each model is marked with both layers under a key of its own, for two recipients. A copy is cropped by a plane, and
parts of both are put together along a plane; each suspect is then turned, moved and resized, its vertices and faces
are shuffled, and its coordinates stored in 32 bits. A row is written as soon as its model is done; run it again to
continue an interrupted run. Models with fewer than `--least` welded points are left out. --marked-only saves the
two absent answers, half of the time. At the end, or at once with --tables, shares of right answers are printed;
wrong ids, and "present" without a mark, are counted besides.

Figures of docs/results/crops.md.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from functools import partial
from time import process_time

import numpy as np

from claims.models import DATA, SIZE_CLASSES, load, size_class
from claims.resumable import measure, parser_of
from meshmark.attacks import parse_chain
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.marking import Extraction, embed, extract
from meshmark.mesh import Mesh
from meshmark.research.benchmark.run.model_files import find_models, spread

CROPS = (0.03, 0.06, 0.09, 0.30, 0.50)
"""Shares of the vertices that are cut off."""
MOSAICS = (0.50, 0.25)
"""Shares of the vertices that are those of the second copy."""
AFTERWARDS = "similarity:1+shuffle:1+float32:1"
CROPPED = tuple(f"crop {share:.0%}" for share in CROPS)
MIXED = tuple(f"mosaic {share:.0%}" for share in MOSAICS)
NOTHING = ("unmarked", "wrong key")
FIGURES = ("whole_seconds", "crop_seconds", "unmarked_seconds")
COLUMNS = ("model", "size_class", "outcome", "whole", *CROPPED, *MIXED, *NOTHING, *FIGURES, "seconds")


def row_of(model: str, *, marked_only: bool = False) -> dict[str, str]:
    """Return the row of one model, without what is asked of unmarked ones where `marked_only`."""
    start = process_time()
    mesh = load(DATA / model)
    digest = hashlib.sha256(model.encode()).digest()
    key, ids = Key(digest), [int.from_bytes(digest[8 * each : 8 * each + 8], "little") for each in (0, 1)]
    row = {"model": model, "size_class": size_class(mesh)}
    try:
        one, other = (embed(mesh, key, id=each) for each in ids)
    except CapacityError as error:
        return row | {"outcome": f"refused: {error}", "seconds": f"{process_time() - start:.2f}"}
    row["outcome"] = one.layers
    marked = one.mesh
    row["whole"], row["whole_seconds"] = _answer(marked, key, ids[:1])
    random = np.random.default_rng(int.from_bytes(digest[:8]))
    taken = []
    for share, title in zip(CROPS, CROPPED, strict=True):
        suspect = parse_chain(f"crop:{share}+{AFTERWARDS}")(marked, random)
        row[title], seconds = _answer(suspect, key, ids[:1])
        taken.append(float(seconds))
    row["crop_seconds"] = f"{np.median(taken):.3f}"
    for share, title in zip(MOSAICS, MIXED, strict=True):
        suspect = parse_chain(AFTERWARDS)(mosaic(marked, other.mesh, share, random), random)
        row[title], _ = _answer(suspect, key, ids)
    if not marked_only:
        row["unmarked"], row["unmarked_seconds"] = _answer(mesh, key, ids)
        row["wrong key"], _ = _answer(marked, Key(hashlib.sha256(digest).digest()), ids)
    return row | {"seconds": f"{process_time() - start:.2f}"}


def mosaic(one: Mesh, other: Mesh, share: float, random: np.random.Generator) -> Mesh:
    """Return a mesh whose vertices beyond a plane in a random direction, a share of them, are those of another."""
    direction = random.normal(size=3)
    height = one.vertices @ (direction / np.linalg.norm(direction))
    beyond = height > np.quantile(height, 1.0 - share)
    return Mesh(np.where(beyond[:, None], other.vertices, one.vertices), one.faces)


def _answer(mesh: Mesh, key: Key, ids: Sequence[int]) -> tuple[str, str]:
    """Return "id" where exactly these ids are read, or what was read instead; and the processor time in seconds."""
    begun = process_time()
    found = extract(mesh, key)
    return _in_a_word(found, ids), f"{process_time() - begun:.3f}"


def _in_a_word(found: Extraction, ids: Sequence[int]) -> str:
    if set(found.ids) == set(ids):
        return "id"
    if set(found.ids) - set(ids):
        return "wrong id"
    return "one id" if found.ids else found.presence


def tables(rows: Sequence[dict[str, str]]) -> str:
    """Return shares of right answers, and figures, by size class, as Markdown."""
    names = [name for _, name in SIZE_CLASSES]
    parts = {name: [row for row in rows if row["size_class"] == name] for name in names} | {"all": list(rows)}
    parts = {name: part for name, part in parts.items() if part}
    both = {name: [row for row in part if row["outcome"] == "both"] for name, part in parts.items()}
    lines = [f"| | {' | '.join(parts)} |", f"|---|{'---|' * len(parts)}"]
    lines.append(f"| models | {' | '.join(str(len(part)) for part in parts.values())} |")
    lines.append(f"| with both layers | {' | '.join(str(len(part)) for part in both.values())} |")
    for title in ("whole", *CROPPED, *MIXED):
        shares = (f"{sum(row[title] == 'id' for row in part)} of {len(part)}" for part in both.values())
        lines.append(f"| {title} | {' | '.join(shares)} |")
    for title in FIGURES:
        medians = (_median([row[title] for row in part]) for part in both.values())
        lines.append(f"| {title.replace('_', ', ')}, median | {' | '.join(medians)} |")
    everything = [row[title] for row in rows for title in ("whole", *CROPPED, *MIXED)]
    nothing = [row[title] for row in rows for title in NOTHING if row[title]]
    lines += [
        "",
        f"Wrong ids: {everything.count('wrong id')}. Present without a mark: "
        f"{sum(each not in ('absent', 'inconclusive') for each in nothing)} of {len(nothing)}.",
    ]
    return "\n".join(lines)


def _median(values: Sequence[str]) -> str:
    known = [float(value) for value in values if value]
    return f"{np.median(known):.2f}" if known else "-"


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure what is left, and print the tables."""
    parser = parser_of(__doc__, 2500)
    parser.add_argument("--marked-only", action="store_true")
    options = parser.parse_args(arguments)
    folder = DATA / "models" / options.split
    models = (f"models/{options.split}/{model}" for model in spread(folder, find_models(folder)))
    print(tables(measure(options, COLUMNS, models, partial(row_of, marked_only=options.marked_only))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
