"""How near the marked copy `recover` with the original comes: `python -m claims.original_recovery ROWS.csv`.

[--split test] [--limit N] [--minutes M] [--least 1000] [--most 12000] [--tables]

Each model is marked with both layers, edited, turned, resized, moved, shuffled and rounded to 32-bit floats; then
`recover` is given key and original, nothing else. Columns of an edit: the largest distance of any vertex of the
marked copy from the recovered model, over the diagonal, what the part was taken from, whether the result is
authentic, and seconds. Continues where it was interrupted.

Figures of docs/decisions/0028-recovery-with-the-original.md.
"""

from __future__ import annotations

import sys

import numpy as np

from claims.models import DATA, load, model_paths
from claims.resumable import Row, measure, parser_of
from meshmark.attacks import Given, find_attack
from meshmark.coding.keys import Key
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.similarity import Similarity, rotation_of
from meshmark.geometry.surface_of import surface_of
from meshmark.marking import authenticate, embed, recover
from meshmark.mesh import FloatArray, Mesh

EDITS = {"bump": 0.05, "move_part": 0.05, "delete_part": 0.05, "paste": 0.05, "crop": 0.3}
DONOR = "classic_elk"
KEY = Key(bytes(range(32)))
# Bar: altered vertices are back within this of their places, over the diagonal.
WITHIN = 1e-6
COLUMNS = [
    "model",
    "points",
    *(f"{edit} {what}" for edit in EDITS for what in ("off", "from", "authentic", "s")),
    "seconds",
]


def turned(mesh: Mesh, rng: np.random.Generator) -> tuple[Mesh, Similarity]:
    """Return the mesh turned, resized, moved, shuffled and in 32-bit floats, and the first three."""
    shift = rng.normal(size=3) * float(np.ptp(mesh.vertices))
    pose = Similarity(
        scale=float(rng.uniform(0.5, 2.0)), rotation=rotation_of(rng.normal(size=3)), shift=shift
    )
    order = rng.permutation(len(mesh.vertices))
    vertices = pose(mesh.vertices[order]).astype(np.float32).astype(np.float64)
    return Mesh(vertices, rng.permutation(np.argsort(order)[mesh.faces])), pose


def off(found: Mesh, truth: FloatArray) -> float:
    """Return how far the farthest of the true places (n, 3) is from a vertex, over their diagonal."""
    distance = np.asarray(kd_tree(found.vertices).query(truth)[0])
    return float(distance.max() / np.linalg.norm(np.ptp(truth, axis=0)))


def row_of(model: str) -> Row:
    """Return the row of a model, its path relative to the data."""
    original, rng = load(DATA / model), np.random.default_rng(len(model))
    donor = load(next(path for path in model_paths("models/train") if DONOR in path.name))
    marked = embed(original, KEY, id=1, layers="both").mesh
    used = np.unique(marked.faces)
    row = {"model": model, "points": str(len(surface_of(original).points))}
    for edit, strength in EDITS.items():
        edited = find_attack(edit).apply(marked, strength, rng, Given(donor=donor)).mesh
        suspect, pose = turned(edited, rng)
        found = recover(suspect, KEY, original=original)
        row["seconds"] = row[f"{edit} s"] = f"{found.seconds:.1f}"
        if found.mesh is not None:
            row[f"{edit} off"] = f"{off(found.mesh, pose(marked.vertices[used])):.1e}"
            row[f"{edit} from"] = str(found.restored_from)
            row[f"{edit} authentic"] = authenticate(found.mesh, KEY).verdict
    return row


def paths(split: str, most: int) -> list[str]:
    """Return the models of a split that have at most so many points."""
    found = [path.relative_to(DATA).as_posix() for path in model_paths(f"models/{split}")]
    return [path for path in found if len(surface_of(load(DATA / path)).points) <= most]


def main() -> int:
    """Measure and print; exit 1 where a vertex is not back."""
    parser = parser_of(__doc__, 1000)
    parser.add_argument("--most", type=int, default=12_000)
    options = parser.parse_args()
    models = () if options.tables else paths(options.split, options.most)
    rows = measure(options, COLUMNS, models, row_of)
    print("| edit | models | recovered | within 1e-6 | largest | authentic |\n|---|---|---|---|---|---|")
    good = bool(rows)
    for edit in EDITS:
        offs = [float(row[f"{edit} off"]) for row in rows if row[f"{edit} off"]]
        near = sum(value <= WITHIN for value in offs)
        authentic = sum(row[f"{edit} authentic"] == "authentic" for row in rows)
        print(
            f"| {edit} | {len(rows)} | {len(offs)} | {near} | {max(offs, default=np.nan):.1e} | {authentic} |"
        )
        good = good and near == len(rows)
    return int(not good)


if __name__ == "__main__":
    sys.exit(main())
