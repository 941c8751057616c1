"""Marks of the authentication layer on the training models of 2,500 points and more.

    python -m claims.marks [--models NAME,...] [--no-edits]

Prints, model by model and then over all: the layer's PSNR, bits per mark and payload bits per point, points
that fail though nothing was done to them under every benign operation, marks that hold by chance, how surely a
single moved point is seen, and how well the map finds local edits. Exits 1 where a bar is missed.

Figures of docs/decisions/0008-authentication-marks.md.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from claims.models import load, model_paths
from meshmark.attacks import ATTACKS
from meshmark.attacks.attack import Attacked, Given
from meshmark.authentication.checks.altered_points import altered_points
from meshmark.authentication.checks.checks import Checks, check
from meshmark.authentication.marks.plan import Marked, mark, plan
from meshmark.authentication.marks.precision import precision_of
from meshmark.coding.keys import Key
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.io import read_mesh, write_mesh
from meshmark.io.file_precision import conform
from meshmark.mesh import Mesh
from meshmark.metrics.tamper import iou, recall

KEY, OTHER = Key(bytes(range(32))), Key(bytes(range(1, 33)))
ID, OTHER_ID = 0x0123456789ABCDEF, 0xFEDCBA9876543210
SMALLEST = 2500
SHARES = (0.005, 0.02, 0.05, 0.2)
# Payload that is left where 55 % of the marks are, and 5 % of those are spent on the code.
NET = 0.55 * 0.95
BENIGN = (
    "shuffle", "float32", "weld", "unweld", "file_obj", "file_ply", "file_stl", "file_glb", "file_3mf"
)  # fmt: skip
FORMATS = ("off", "obj", "ply", "stl", "glb", "gltf", "3mf")


def main() -> int:
    parser = argparse.ArgumentParser(description="marks of the authentication layer")
    parser.add_argument("--models", default="", help="parts of names, separated by commas")
    parser.add_argument("--no-edits", action="store_true")
    options = parser.parse_args()
    wanted = options.models.split(",")
    figures: dict[str, list[float]] = defaultdict(list)
    for path in model_paths("models/train"):
        mesh = load(path)
        if len(weld(mesh).points) < SMALLEST or not any(name in path.name for name in wanted):
            continue
        _model(path.name.split(".")[0], mesh, figures, not options.no_edits)
    return _report(figures)


def _model(name: str, mesh: Mesh, figures: dict[str, list[float]], edits: bool) -> None:
    surface = weld(mesh)
    marked, done = _marked(mesh, ID)
    psnr = _psnr(surface, done)
    net = 25 / 32 * done.count * done.symbol_bits * NET / len(surface.points)
    found, seconds = _timed(weld(marked), None)
    fresh = {
        attack: _fresh(attacked) for attack, attacked in benign_operations(marked, np.random.default_rng(1))
    }
    one, ring = _single(marked, done, 1.42), _single(marked, done, 3.0)
    print(
        f"{name:30} {len(surface.points):6} points  {psnr:.1f} dB  {done.bits_per_mark} bits  "
        f"{net:.2f} net/point  eligible {found.eligible.mean():.3f}  id {found.nonce == ID}  "
        f"{seconds:.2f} s  single {one:.3f} {ring:.3f}",
        flush=True,
    )
    for attack, failing in fresh.items():
        figures[f"benign {attack}: intact points that fail"].append(failing)
        if failing:
            print(f"  {attack}: {failing:.0f} points fail")
    figures["PSNR, dB"].append(psnr)
    figures["net payload, bits per point"].append(net)
    figures["seen: one point moved by a step"].append(one)
    figures["seen: one point moved by two steps"].append(ring)
    for label, mesh_, key in (("wrong key", marked, OTHER), ("unmarked", mesh, KEY)):
        chance = check(weld(mesh_), key, ID)
        figures[f"{label}: share of points that pass"].append(float(chance.passed.mean()))
        figures[f"{label}: log10 of the chance"].append(chance.log10_chance)
    if edits:
        _edited(marked, _marked(mesh, OTHER_ID)[0], figures)


def _marked(mesh: Mesh, nonce: int) -> tuple[Mesh, Marked]:
    surface = weld(mesh)

    def symbols(index: NDArray[np.uint32]) -> NDArray[np.uint16]:
        return (index >> np.uint32(28)).astype(np.uint16)

    done = mark(plan(surface, KEY, precision_of(mesh)), KEY, nonce, symbols)
    return mesh.with_vertices(conform(mesh, done.points[surface.point_of_vertex])), done


def _psnr(surface: Surface, done: Marked) -> float:
    diagonal = np.linalg.norm(np.ptp(surface.points, axis=0))
    rms = np.sqrt(((done.points - surface.points) ** 2).sum(axis=1).mean())
    return float(20.0 * np.log10(diagonal / rms))


def _timed(surface: Surface, nonce: int | None) -> tuple[Checks, float]:
    start = perf_counter()
    return check(surface, KEY, nonce), perf_counter() - start


def _fresh(mesh: Mesh) -> float:
    """Return how many points fail."""
    found = check(weld(mesh), KEY)
    return float((found.eligible & ~found.verified).sum()) if found.nonce == ID else float("nan")


def benign_operations(mesh: Mesh, rng: np.random.Generator) -> Iterator[tuple[str, Mesh]]:
    """Yield a model after each operation that alters nothing, and after none."""
    yield "nothing", mesh
    for name in BENIGN:
        yield name, ATTACKS[name](mesh, 1, rng)
    for _ in range(2):
        turned = ATTACKS["similarity"](mesh, 1, rng)
        yield "similarity", turned
        yield "similarity, float32", ATTACKS["float32"](turned, 1, rng)
    for name in FORMATS:
        with tempfile.TemporaryDirectory(prefix="meshmark-") as folder:
            path = Path(folder) / f"model.{name}"
            write_mesh(mesh, path)
            yield f"to {name}", read_mesh(path)


def _single(mesh: Mesh, done: Marked, steps: float) -> float:
    """Return the share of single points, far from each other, that are seen when each is moved by `steps`.

    Steps of the ring that the point is in the middle of: a step is `step` times the ring's spread, 3.3 at the
    median.
    """
    surface = weld(mesh)
    graph = adjacency(unique_edges(surface.faces), len(surface.points))
    rng = np.random.default_rng(3)
    before = check(surface, KEY, ID)
    free = before.eligible.copy()
    chosen: list[int] = []
    while len(chosen) < 60 and free.any():
        chosen.append(int(rng.choice(np.flatnonzero(free))))
        near = np.zeros(len(free))
        near[chosen[-1]] = 1.0
        for _ in range(5):
            near = graph @ near + near
        free &= near == 0.0
    way = rng.normal(size=(len(chosen), 3))
    way *= steps * done.step * 3.3 / np.linalg.norm(way, axis=1)[:, None]
    points = surface.points.copy()
    points[chosen] += way
    moved = Mesh(points, surface.faces)
    after = check(weld(moved), KEY, ID)
    seen = after.eligible & ~after.verified
    around = graph[chosen] @ seen.astype(float) + seen[chosen]
    return float((around > 0).mean())


Edit = Callable[[Mesh, float, np.random.Generator, Mesh], Attacked]


def _edited(mesh: Mesh, other: Mesh, figures: dict[str, list[float]]) -> None:
    for name, edit in _edits().items():
        for share in SHARES:
            attacked = edit(mesh, share, np.random.default_rng(round(1000 * share)), other)
            surface = weld(attacked.mesh)
            found = altered_points(surface, check(surface, KEY, ID))[surface.point_of_vertex]
            assert attacked.altered is not None
            figures[f"map {name} {share:g} IoU"].append(iou(attacked.altered, found))
            figures[f"map {name} {share:g} recall"].append(recall(attacked.altered, found))


def _edits() -> dict[str, Edit]:
    def by_name(name: str) -> Edit:
        return lambda mesh, share, rng, other: ATTACKS[name].apply(mesh, share, rng, Given(donor=other))

    names = (
        "bump",
        "dent",
        "smooth_part",
        "move_part",
        "scale_part",
        "delete_part",
        "add_part",
        "replace_part",
    )
    return {name: by_name(name) for name in names} | {
        "paste, another model": _pasted_other,
        "paste, another place": lambda mesh, share, rng, _: _pasted_other(mesh, share, rng, mesh),
    }


def _pasted_other(mesh: Mesh, share: float, rng: np.random.Generator, donor: Mesh) -> Attacked:
    """Lay in a part of a donor that has other numbers than the model, so that another place is taken."""
    return ATTACKS["paste"].apply(mesh, share, rng, Given(donor=ATTACKS["shuffle"](donor, 1, rng)))


# Figure, the end of its name, what is compared, and its bar.
BARS: tuple[tuple[str, str, Callable[[list[float]], bool]], ...] = (
    ("PSNR, dB", "all at least 80", lambda values: min(values) >= 80.0),
    ("net payload, bits per point", "all at least 1", lambda values: min(values) >= 1.0),
    ("intact points that fail", "none", lambda values: max(values) == 0.0 and not np.isnan(values).any()),
    ("log10 of the chance", "all above -6", lambda values: min(values) > -6.0),
    (
        "seen: one point moved by two steps",
        "mean at least 0.85",
        lambda values: float(np.mean(values)) >= 0.85,
    ),
    ("0.005 IoU", "mean at least 0.6", lambda values: float(np.mean(values)) >= 0.6),
    ("IoU", "mean at least 0.85", lambda values: float(np.mean(values)) >= 0.85),
    ("recall", "mean at least 0.95", lambda values: float(np.mean(values)) >= 0.95),
)


def _report(figures: dict[str, list[float]]) -> int:
    missed = 0
    print("\n| figure | mean | least | most | bar |\n|---|---|---|---|---|")
    for name, values in figures.items():
        bar = next(((text, holds) for end, text, holds in BARS if name.endswith(end)), None)
        verdict = "" if bar is None else f"{bar[0]}: {'yes' if bar[1](values) else 'NO'}"
        missed += bar is not None and not bar[1](values)
        print(f"| {name} | {np.mean(values):.4g} | {min(values):.4g} | {max(values):.4g} | {verdict} |")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
