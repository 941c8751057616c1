"""Recovery of local edits, by a miniature of one bit a vertex: `python -m claims.recovery`.

[--folder models/train] [--least-points 2500] [--most-points 60000] [--limit N] [--edits bump ...]
[--shares 0.02 ...] [--seed N] [--bits 1.0]

Each edit is made on the unmarked model; the truth of what it altered goes to `recover` with the miniature. The
error of the altered part is the RMS distance, both ways and over the diagonal: of its vertices from the original,
and of the original's vertices that were moved or lost from the model. Columns: medians before and after, the worst
after, how many times smaller; for edits that move vertices only, the RMS distance of each from its own place; the
slowest.

Figures of docs/decisions/0007-payload-recovery.md.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from claims.models import load, model_paths
from meshmark.attacks import Given, find_attack
from meshmark.attacks.attack import Attacked
from meshmark.errors import MeshmarkError
from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.recovery.miniature import miniature, read_miniature
from meshmark.recovery.repair import recover

EDITS = ("bump", "dent", "move_part", "delete_part", "replace_part", "paste")
SHARES = (0.005, 0.02, 0.05, 0.2)
DONOR = "classic_elk"
MOST, TIMES = 0.007, 4.0


@dataclass(frozen=True)
class Row:
    """What became of one edit; places are NaN where vertices came or went."""

    before: float
    after: float
    place_before: float
    place_after: float
    closed: bool
    seconds: float

    @property
    def good(self) -> bool:
        """Whether the row is within the bar."""
        return self.after <= MOST and self.after * TIMES <= self.before and self.closed


def judged(mesh: Mesh, edit: str, share: float, donor: Mesh, content: bytes, seed: int) -> Row:
    rng = np.random.default_rng(seed)
    attacked = find_attack(edit).apply(mesh, share, rng, Given(donor=donor))
    suspect = weld(attacked.mesh)
    altered = np.zeros(len(suspect.points), bool)
    altered[suspect.point_of_vertex[attacked.altered]] = True
    start = perf_counter()
    found = recover(suspect, altered, content)
    seconds = perf_counter() - start
    changed = found.moved | (found.origin < 0)
    return compared(mesh, attacked, Mesh(found.points, found.faces), changed, seconds)


def compared(mesh: Mesh, attacked: Attacked, found: Mesh, changed: NDArray[np.bool_], seconds: float) -> Row:
    """Return the row of a recovered mesh of which the vertices `changed` (n,) are not as in the edited one."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    stayed = attacked.origin[(attacked.origin >= 0) & ~attacked.altered]
    used[stayed] = False
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    home = SurfaceIndex(mesh.vertices, mesh.faces)

    def error(places: FloatArray, surface: SurfaceIndex) -> float:
        there, back = home.nearest(places).distances, surface.nearest(mesh.vertices[used]).distances
        parts = [np.mean(part**2) for part in (there, back) if len(part)]
        return float(np.sqrt(np.mean(parts))) / size if parts else 0.0

    assert attacked.altered is not None
    edited = SurfaceIndex(attacked.mesh.vertices, attacked.mesh.faces)
    before = error(attacked.mesh.vertices[attacked.altered], edited)
    after = error(found.vertices[changed], SurfaceIndex(found.vertices, found.faces))
    places = (float("nan"), float("nan"))
    if attacked.altered.any() and len(found.vertices) == len(mesh.vertices) == len(attacked.mesh.vertices):
        rows = attacked.altered
        steps = [(each - mesh.vertices)[rows] for each in (attacked.mesh.vertices, found.vertices)]
        one, other = (float(np.sqrt((step**2).sum(axis=1).mean())) / size for step in steps)
        places = one, other
    closed = is_closed(found.faces) or not is_closed(mesh.faces)
    return Row(before, after, *places, closed, seconds)


def is_closed(faces: IntArray) -> bool:
    """Whether every edge has two faces."""
    return 2 * len(unique_edges(faces)) == 3 * len(faces) and _twice(faces)


def _twice(faces: IntArray) -> bool:
    ends = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return bool((np.unique(ends, axis=0, return_counts=True)[1] == 2).all())


def main() -> int:
    """Measure and print; exit 1 where a row misses the bar."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", default="models/train")
    parser.add_argument("--least-points", type=int, default=2500)
    parser.add_argument("--most-points", type=int, default=60_000)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--edits", nargs="+", default=list(EDITS))
    parser.add_argument("--shares", nargs="+", type=float, default=list(SHARES))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--bits", type=float, default=1.0, help="bits of payload a vertex")
    options = parser.parse_args()
    donor = load(next(path for path in model_paths("models/train") if DONOR in path.name))
    rows: dict[tuple[str, float], list[Row]] = defaultdict(list)
    number = 0
    for path in model_paths(options.folder):
        welded = weld(load(path))
        if not options.least_points <= len(welded.points) <= options.most_points or number == options.limit:
            continue
        number += 1
        mesh = Mesh(welded.points, welded.faces)
        start = perf_counter()
        content = miniature(mesh.vertices, mesh.faces, int(options.bits * len(mesh.vertices) / 8))
        size = (
            f"{len(content)} bytes, {len(read_miniature(content)[0])} points, {perf_counter() - start:.1f} s"
        )
        print(f"{path.name.split('.')[0]}: {len(mesh.vertices)} points, miniature of {size}", flush=True)
        for edit in options.edits:
            for share in options.shares:
                try:
                    row = judged(mesh, edit, share, donor, content, options.seed)
                except MeshmarkError as error:
                    print(f"  {edit} {share:g}: {error}")
                    continue
                rows[edit, share].append(row)
                if not row.good:
                    closed = "" if row.closed else ", not closed"
                    print(
                        f"  missed: {edit} {share:g}: {row.before:.3%} -> {row.after:.3%}{closed}", flush=True
                    )
    print("\n| edit | share | models | before | after | worst | times | within the bar | places | seconds |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for (edit, share), some in rows.items():
        before, after = (np.array([getattr(row, name) for row in some]) for name in ("before", "after"))
        moved = [(row.place_before, row.place_after) for row in some if row.place_before == row.place_before]
        places = " -> ".join(f"{x:.2%}" for x in np.median(moved, axis=0)) if moved else ""
        times = float(np.median(before / np.maximum(after, 1e-12)))
        good, slowest = sum(row.good for row in some), max(row.seconds for row in some)
        cells = [edit, f"{share:.1%}", str(len(some)), f"{np.median(before):.2%}", f"{np.median(after):.3%}"]
        cells += [f"{after.max():.2%}", f"{times:.0f}", f"{good}/{len(some)}", places, f"{slowest:.0f}"]
        print("|", " | ".join(cells), "|")
    return int(any(not row.good for some in rows.values() for row in some))


if __name__ == "__main__":
    sys.exit(main())
