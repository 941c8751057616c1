"""Share of models whose id comes back blind, untouched and after what leaves the shape alone, per size class.

python -m claims.clean_channel [--folders models/test psb/test] [--strength standard] [--workers 2]
    [--limit N] [--variants none similarity ...]

Figures of docs/results/clean-channel.md.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np

from claims.models import SIZE_CLASSES, load, model_paths, size_class
from meshmark.coding.keyed import rotation
from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.io import FORMATS, read_mesh, write_mesh
from meshmark.marking import extract
from meshmark.marking.marked_file import embed_file
from meshmark.mesh import Mesh

Variant = Callable[[Mesh, np.random.Generator], Mesh]


def similarity(mesh: Mesh, random: np.random.Generator) -> Mesh:
    """Turn, scale by 0.01 to 100, and move."""
    turned = mesh.vertices @ rotation(random.bytes(32)).T * 10.0 ** random.uniform(-2, 2)
    return Mesh(turned + random.normal(size=3) * np.ptp(turned, axis=0), mesh.faces)


def shuffle(mesh: Mesh, random: np.random.Generator) -> Mesh:
    """Put vertices and faces, and the corners of each face, into another order."""
    order = random.permutation(len(mesh.vertices))
    place = np.argsort(order)
    faces = place[mesh.faces[random.permutation(len(mesh.faces))]]
    starts = random.integers(3, size=len(faces))[:, None]
    return Mesh(mesh.vertices[order], np.take_along_axis(faces, (starts + np.arange(3)) % 3, axis=1))


def float32(mesh: Mesh, _: np.random.Generator) -> Mesh:
    """Round coordinates to single precision."""
    return Mesh(mesh.vertices.astype(np.float32).astype(np.float64), mesh.faces)


def midpoint(mesh: Mesh, _: np.random.Generator) -> Mesh:
    """Split every triangle into four at its edges' midpoints."""
    edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    a, b, c = mesh.faces.T
    ab, bc, ca = (inverse.reshape(-1, 3) + len(mesh.vertices)).T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    vertices = np.concatenate([mesh.vertices, mesh.vertices[unique].mean(axis=1)])
    return Mesh(vertices, np.concatenate([np.stack(part, axis=1) for part in parts]))


def through(extension: str) -> Variant:
    """Convert to a format and read that file."""

    def convert(mesh: Mesh, _: np.random.Generator) -> Mesh:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"model{extension}"
            write_mesh(mesh, path)
            return read_mesh(path)

    return convert


VARIANTS: dict[str, Variant] = {
    "none": lambda mesh, _: mesh,
    "similarity": similarity,
    "shuffle": shuffle,
    "float32": float32,
    "midpoint": midpoint,
    **{f"through {name}": through(entry.extensions[0]) for name, entry in FORMATS.items()},
}


def run_model(path: Path, strength: str, variants: Sequence[str]) -> dict[str, object]:
    """Mark a model through the file system and read every variant; what fails is a row, not a crash."""
    name = path.name.split(".")[0]
    random = np.random.default_rng(int.from_bytes(hashlib.sha256(name.encode()).digest()[:8], "little"))
    key, identity = Key(random.bytes(32)), int.from_bytes(random.bytes(8), "little")
    row: dict[str, object] = {"model": name, "size": "?", "note": ""}
    try:
        mesh = load(path)
        row["size"], row["points"] = size_class(mesh), len(mesh.vertices)
        with tempfile.TemporaryDirectory() as folder:
            plain, marked = Path(folder) / "in.off", Path(folder) / "out.off"
            write_mesh(mesh, plain)
            result = embed_file(plain, marked, key, id=identity, strength=strength, layers="ownership")
            again = read_mesh(marked)
        change = again.vertices - mesh.vertices
        diagonal = np.linalg.norm(np.ptp(mesh.vertices, axis=0))
        row["rms"] = 100.0 * float(np.sqrt((change**2).sum(axis=1).mean()) / diagonal)
        row["carriers"], row["seconds"] = result.carriers, result.seconds
        for variant in variants:
            row[variant] = extract(VARIANTS[variant](again, random), key).id == identity
    except MeshmarkError as error:
        row["note"] = str(error)
    return row


def main() -> int:
    """Run and print; exit 1 where a class of models/test misses its bar."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folders", nargs="+", default=["models/test"])
    parser.add_argument("--strength", default="standard")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--variants", nargs="+", choices=VARIANTS, default=list(VARIANTS))
    arguments = parser.parse_args()
    paths = list(model_paths(*arguments.folders))[: arguments.limit]
    rows = []
    with ProcessPoolExecutor(arguments.workers) as pool:
        jobs = [pool.submit(run_model, path, arguments.strength, arguments.variants) for path in paths]
        for job in as_completed(jobs):
            rows.append(row := job.result())
            failed = [variant for variant in arguments.variants if row.get(variant) is not True]
            state = "all read" if not failed else row["note"] or "MISSED " + ", ".join(failed)
            print(
                f"{row['model']:32s} {row.get('points', 0):>7} points  rms {row.get('rms', 0):.4f} %  "
                f"carriers {row.get('carriers', '-'):>4}  {row.get('seconds', 0):6.2f} s  {state}",
                flush=True,
            )
    return report(rows, arguments.strength, arguments.variants)


def report(rows: list[dict[str, object]], strength: str, variants: Sequence[str]) -> int:
    """Print success per size class and variant; a refusal is a miss."""
    classes: dict[object, list[dict[str, object]]] = defaultdict(list)
    for row in rows:
        classes[row["size"]].append(row)
    print(f"\nid recovered blind, strength {strength}, share of all models (refusals are misses)\n")
    print("| size class | models | refused | largest RMS % |", " | ".join(variants), "|")
    print("|---|" + "---|" * (len(variants) + 3))
    missed = 0
    for _, name in (*SIZE_CLASSES, (0, "?")):
        group = classes.get(name, [])
        if not group:
            continue
        rates = [sum(row.get(variant) is True for row in group) / len(group) for variant in variants]
        refused = sum(bool(row["note"]) for row in group)
        worst = max(float(str(row.get("rms", 0.0))) for row in group)
        print(
            f"| {name} | {len(group)} | {refused} | {worst:.4f} |",
            " | ".join(f"{100 * r:.1f} %" for r in rates),
            "|",
        )
        bar = {"> 20,000": 1.0, "5,000-20,000": 0.95, "2,500-5,000": 0.95}.get(name, 0.0)
        missed += min(rates) < bar
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
