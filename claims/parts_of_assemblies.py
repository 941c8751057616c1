"""Whether a part that is taken out of a marked assembly still tells the id, by the key alone.

python -m claims.parts_of_assemblies ROWS.csv [--split test] [--limit N] [--minutes M] [--least 300] [--most N]
                                     [--layers both] [--tables]

Models of the benchmark and of the collection with several connected components, one at least of `--least` welded
points, are marked with a key of their own, with the default options or with `--layers ownership`. Of the components
of that size up to `MOST` of each model, a seeded choice, are taken out, one by one: only their faces are kept,
turned, scaled, in another order, as 32-bit floats. Models of more than `--most` points are left out. A row is
written as soon as a model is done; run it again to continue an interrupted run. At the end, or at once with
--tables, shares of exact ids are printed by the size of the part.

Figures of docs/decisions/0035-parts-of-assemblies.md.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from time import process_time

import numpy as np

from claims.models import DATA, load, model_paths
from claims.princeton import models_of
from claims.resumable import measure, parser_of
from meshmark.attacks import parse_chain
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.geometry.components import connected_components
from meshmark.geometry.surface_of import surface_of
from meshmark.marking import embed, extract
from meshmark.mesh import IntArray, Mesh

COLUMNS = (
    "model", "points", "components", "large", "outcome", "whole", "parts", "others", "wrong_key", "embed_seconds",
    "extract_seconds", "absent_seconds", "rms", "seconds",
)  # fmt: skip
CHANGE = "similarity:1+shuffle:1+float32:1"
MOST = 6
SIZES = (300, 500, 1000, 2500, 5000, 10**9)


def components_of(mesh: Mesh) -> list[IntArray]:
    """Return the faces (of the mesh) of each connected component of its welded surface, most points first."""
    surface = surface_of(mesh)
    count, label = connected_components(surface.graph)
    size = np.bincount(label[surface.used], minlength=count)
    of_face = label[surface.point_of_vertex[mesh.faces[:, 0]]]
    order = np.argsort(-size, kind="stable")
    return [np.flatnonzero(of_face == each) for each in order if size[each]]


def taken_out(mesh: Mesh, faces: IntArray) -> Mesh:
    """Return the mesh of some faces of another one, with the vertices that they use."""
    rows, corners = np.unique(mesh.faces[faces], return_inverse=True)
    return Mesh(mesh.vertices[rows], corners.reshape(-1, 3))


def row_of(model: str, *, least: int, most: float, layers: str) -> dict[str, str]:
    """Return the row of one model; only its size of one that has no large part beside others."""
    start = process_time()
    return _row_of(model, (least, most), layers) | {"seconds": f"{process_time() - start:.2f}"}


def _row_of(model: str, points: tuple[int, float], layers: str) -> dict[str, str]:
    mesh = load(DATA / model)
    components = components_of(mesh)
    sizes = [len(surface_of(taken_out(mesh, each)).points) for each in components[:200]]
    large = [number for number, size in enumerate(sizes) if size >= points[0]]
    row = {
        "model": model,
        "points": str(len(surface_of(mesh).points)),
        "components": str(len(components)),
        "large": str(len(large)),
    }
    if len(components) < 2 or not large or int(row["points"]) > points[1]:
        return row | {"outcome": "left out"}
    digest = hashlib.sha256(model.encode()).digest()
    key, identity = Key(digest), int.from_bytes(digest[:8], "little")
    begun = process_time()
    try:
        made = embed(mesh, key, id=identity, layers=None if layers == "both" else layers)
    except CapacityError as error:
        return row | {"outcome": f"refused: {error}"}
    row |= {"outcome": made.layers, "embed_seconds": f"{process_time() - begun:.2f}"}
    row["rms"] = f"{100 * made.rms_over_diagonal:.5f}"
    begun = process_time()
    row["whole"] = _answer(made.mesh, key, identity)
    row["extract_seconds"] = f"{process_time() - begun:.2f}"
    rng = np.random.default_rng(int.from_bytes(digest[8:16], "little"))
    chosen = sorted(rng.permutation(large)[:MOST])
    answers = []
    for number in chosen:
        part = parse_chain(CHANGE)(taken_out(made.mesh, components[number]), rng)
        answers.append(f"{sizes[number]}:{_answer(part, key, identity)}")
    row["parts"] = " ".join(answers)
    part = parse_chain(CHANGE)(taken_out(made.mesh, components[chosen[0]]), rng)
    other = Key(hashlib.sha256(digest).digest())
    row["others"] = _answer(part, other, identity)
    begun = process_time()
    row["wrong_key"] = _answer(made.mesh, other, identity)
    return row | {"absent_seconds": f"{process_time() - begun:.2f}"}


def _answer(mesh: Mesh, key: Key, identity: int) -> str:
    """Return "id", "wrong", or what `extract` says instead."""
    found = extract(mesh, key)
    if found.id is None:
        return found.presence
    return "id" if found.id == identity else "wrong"


def table(rows: Sequence[dict[str, str]]) -> str:
    """Return a table in Markdown of the rows of models that were marked."""
    marked = [row for row in rows if row["parts"]]
    parts = [entry.split(":") for row in marked for entry in row["parts"].split()]
    lines = ["| points of the part | parts | ids read | wrong |", "|---|---|---|---|"]
    for low, high in zip((SIZES[0], *SIZES[:-1]), (SIZES[-1], *SIZES[1:]), strict=True):
        said = [answer for size, answer in parts if low <= int(size) < high]
        if said:
            title = f"{low:,} and more" if high == SIZES[-1] else f"{low:,} to {high:,}"
            ids = said.count("id")
            lines.append(f"| {title} | {len(said)} | {ids} ({ids / len(said):.0%}) | {said.count('wrong')} |")
    silent = [row[name] for row in marked for name in ("others", "wrong_key")]
    refused = sum(row["outcome"].startswith("refused") for row in rows)
    whole = sum(row["whole"] == "id" for row in marked)
    present = sum(each not in ("absent", "inconclusive") for each in silent)
    seconds = (
        f"{name.split('_')[0]} {sum(float(row[name]) for row in marked):.1f}"
        for name in ("embed_seconds", "extract_seconds", "absent_seconds")
    )
    lines += [
        "",
        f"{len(marked)} models, {refused} refused; read whole {whole}; present under another key {present} of "
        f"{len(silent)}.",
        f"Seconds, sum: {', '.join(seconds)}.",
    ]
    return "\n".join(lines)


def models(split: str) -> Iterator[str]:
    """Yield the models of a split, relative to the data."""
    yield from models_of([split])
    yield from (str(path.relative_to(DATA)) for path in model_paths(f"models/{split}"))


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure what is left, and print the table."""
    parser = parser_of(__doc__, 300)
    parser.add_argument("--most", type=float, default=float("inf"), help="points of a model")
    parser.add_argument("--layers", default="both", choices=["both", "ownership"])
    options = parser.parse_args(arguments)
    measured = partial(row_of, least=options.least, most=options.most, layers=options.layers)
    print(table(measure(options, COLUMNS, models(options.split), measured)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
