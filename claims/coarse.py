"""What marks of Princeton models survive, how visible they are, and what marking and reading cost, by size class.

python -m claims.coarse ROWS.csv [--split test] [--limit N] [--minutes M] [--least 40] [--tables]

Each model is marked with an id alone, with a key of its own, in an order in which any first few are spread over
sizes, and once more with both layers, to see whether the marks of authentication fit and hold. A row is written as
soon as its model is done; run it again to continue an interrupted run. Models with fewer than `--least` welded
points are left out. At the end, or at once with --tables, shares of exact ids are printed by size class, for all
changes of `CHANGES`; wrong ids, and "present" where there is no mark, are counted besides.

Figures of docs/results/coarse.md.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable, Sequence
from time import process_time

import numpy as np

from claims.models import DATA, SIZE_CLASSES, load, size_class
from claims.princeton import models_of
from claims.resumable import measure, parser_of
from meshmark.attacks import parse_chain
from meshmark.authentication.checks.checks import check
from meshmark.certificate.certificate import Certificate
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, MeshmarkError
from meshmark.geometry.areas import area_vectors
from meshmark.geometry.plane_patches import PlanePatches
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import VisibleChange
from meshmark.marking import authenticate, embed, extract
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.embedding_task import PLANE_SHARE

CHANGES = (
    "similarity:1+shuffle:1+float32:1",
    "similarity:1+unweld:1+file_stl:1",
    "file_off:1",
    "file_obj:1",
    "file_ply:1",
    "file_glb:1",
    "file_gltf:1",
    "file_3mf:1",
    "six digits",
    "six decimals",
    "other diagonals",
    "midpoint:1",
    "similarity:1+quantisation:16",
    "similarity:1+quantisation:14",
    "similarity:1+quantisation:12",
    "similarity:1+quantisation:11",
    "noise:0.0002+similarity:1",
    "noise:0.0005+similarity:1",
    "noise:0.001+similarity:1",
)
"""Chains of attacks, and three that are made here; read with the key alone."""
CERTIFIED = ("similarity:1+delete_part:0.1", "similarity:1+delete_part:0.3")
"""Chains of attacks that are read with the certificate."""
FIGURES = (
    "points",
    "carriers",
    "rms",
    "largest",
    "visible",
    "plane",
    "off_plane",
    "embed_seconds",
    "extract_seconds",
)
SIGNED = ("both layers", "signed", "watched", "authentic", "one point moved")
"""Of a second copy, with both layers: the outcome, marks, share of the points that they watch, and two verdicts."""
COLUMNS = (
    "model", "size_class", "outcome", *FIGURES, *CHANGES, *CERTIFIED, "unmarked", "wrong key", *SIGNED, "seconds",
)  # fmt: skip
# Faces whose normals differ by less (1 - cosine) lie in one plane.
PLANE = 1e-6


def row_of(model: str) -> dict[str, str]:
    """Return the row of one model."""
    start = process_time()
    mesh = load(DATA / model)
    digest = hashlib.sha256(model.encode()).digest()
    key, identity = Key(digest), int.from_bytes(digest[:8], "little")
    row = {"model": model, "size_class": size_class(mesh)}
    begun = process_time()
    try:
        made = embed(mesh, key, id=identity, layers="ownership")
    except CapacityError as error:
        return row | {"outcome": f"refused: {error}", "seconds": f"{process_time() - start:.2f}"}
    row["embed_seconds"] = f"{process_time() - begun:.3f}"
    surface = surface_of(mesh)
    planes = PlanePatches.of(surface.points, surface.faces)
    after = made.mesh.vertices[surface.vertex_of_point]
    begun = process_time()
    row["outcome"] = _answer(made.mesh, key, identity)
    row["extract_seconds"] = f"{process_time() - begun:.3f}"
    row |= {
        "points": str(int(made.ownership is not None and made.ownership.at_points)),
        "carriers": str(made.carriers),
        "rms": f"{100 * made.rms_over_diagonal:.5f}",
        "largest": f"{100 * made.max_over_diagonal:.5f}",
        "visible": f"{100 * VisibleChange(surface.points, surface.faces).of(after).share:.2f}",
        "plane": f"{100 * planes.share:.2f}",
        "off_plane": f"{100 * planes.off_plane(after) / surface.diagonal:.5f}",
    }
    for change in CHANGES:
        random = _random(model, change)
        try:
            row[change] = _answer(changed(change, made.mesh, surface, random), key, identity)
        except MeshmarkError as error:
            row[change] = f"refused: {error}"
    certificate = made.certificate
    for change in CERTIFIED:
        random = _random(model, change)
        try:
            row[change] = _answer(parse_chain(change)(made.mesh, random), key, identity, certificate)
        except MeshmarkError as error:
            row[change] = f"refused: {error}"
    row |= _signed(mesh, key, identity, model)
    row["unmarked"] = _answer(mesh, key, identity)
    row["wrong key"] = _answer(made.mesh, Key(hashlib.sha256(digest).digest()), identity)
    return row | {"seconds": f"{process_time() - start:.2f}"}


def _random(model: str, change: str) -> np.random.Generator:
    return np.random.default_rng(int.from_bytes(hashlib.sha256(f"{model} {change}".encode()).digest()[:8]))


def _signed(mesh: Mesh, key: Key, identity: int, model: str) -> dict[str, str]:
    """Return what `SIGNED` names."""
    try:
        made = embed(mesh, key, id=identity, layers="both", payload="none")
    except CapacityError as error:
        return {"both layers": f"refused: {error}"}
    assert made.authentication is not None
    surface = surface_of(made.mesh)
    watched = check(surface, key, identity).verified
    random = _random(model, "signed")
    same = parse_chain("similarity:1+shuffle:1+float32:1")(made.mesh, random)
    points = surface.points.copy()
    points[random.choice(np.flatnonzero(surface.used))] += 0.01 * surface.diagonal * random.normal(size=3)
    moved = made.mesh.with_vertices(points[surface.point_of_vertex])
    return {
        "both layers": "id",
        "signed": str(made.authentication.marks),
        "watched": f"{100 * watched.sum() / surface.used.sum():.1f}",
        "authentic": authenticate(same, key).verdict,
        "one point moved": authenticate(moved, key).verdict,
    }


def _answer(mesh: Mesh, key: Key, identity: int, reference: Certificate | None = None) -> str:
    """Return "id", "wrong id", or what `extract` says instead."""
    found = extract(mesh, key, reference=reference)
    if found.id is None:
        return found.presence
    return "id" if found.id == identity else "wrong id"


def changed(change: str, mesh: Mesh, surface: Surface, random: np.random.Generator) -> Mesh:
    """Return a marked mesh after a change; surface: of the unmarked one."""
    if change == "six digits":
        return mesh.with_vertices(np.char.mod("%.6g", mesh.vertices).astype(np.float64))
    if change == "six decimals":
        return mesh.with_vertices(np.char.mod("%.6f", mesh.vertices).astype(np.float64))
    if change == "other diagonals":
        marked = mesh.vertices[surface.vertex_of_point]
        return Mesh(marked, other_diagonals(surface, random))
    return parse_chain(change)(mesh, random)


def other_diagonals(surface: Surface, random: np.random.Generator) -> np.ndarray:
    """Return faces with the other diagonal in about half of the plane convex quadrilaterals of two faces."""
    faces, points = surface.faces.copy(), surface.points
    normals = _normals(points, faces)
    owner: dict[tuple[int, int], int] = {}
    free = np.ones(len(faces), bool)
    for face in random.permutation(len(faces)):
        for corner in range(3):
            a, b, c = (int(faces[face, (corner + turn) % 3]) for turn in range(3))
            other = owner.get((b, a))
            if other is None:
                owner[a, b] = int(face)
                continue
            if not (free[face] and free[other]) or 1.0 - normals[face] @ normals[other] > PLANE:
                continue
            d = next(int(point) for point in surface.faces[other] if point not in (a, b))
            pair = np.array([[c, d, b], [d, c, a]])
            if c == d or (_normals(points, pair) @ normals[face] < 0.999).any() or random.random() < 0.5:
                continue
            faces[face], faces[other] = pair
            free[face] = free[other] = False
            break
    return faces


def _normals(points: FloatArray, faces: np.ndarray) -> FloatArray:
    vectors = area_vectors(points, faces)
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)[:, None])


def tables(rows: Sequence[dict[str, str]]) -> str:
    """Return shares of exact ids, and figures, by size class, as Markdown."""
    names = [name for _, name in SIZE_CLASSES]
    parts = {name: [row for row in rows if row["size_class"] == name] for name in names} | {"all": list(rows)}
    lines = [f"| | {' | '.join(parts)} |", f"|---|{'---|' * len(parts)}"]
    marked = {name: [row for row in part if row["embed_seconds"]] for name, part in parts.items()}

    def line(title: str, values: Iterable[str]) -> None:
        lines.append(f"| {title} | {' | '.join(values)} |")

    line("models", (str(len(part)) for part in parts.values()))
    line("marked", (str(len(part)) for part in marked.values()))
    line("of these at points", (str(sum(row["points"] == "1" for row in part)) for part in marked.values()))
    for title in ("outcome", *CHANGES, *CERTIFIED, "both layers"):
        shown = {"outcome": "as written", "both layers": "both layers fit"}.get(title, title)
        shown += ", with certificate" if title in CERTIFIED else ""
        line(shown, (_share(part, title) for part in marked.values()))
    line(
        "authentic, turned, in another order",
        (_share(part, "authentic", "authentic") for part in marked.values()),
    )
    line("one point moved: altered", (_share(part, "one point moved", "altered") for part in marked.values()))
    watched = {name: [row for row in part if row["watched"]] for name, part in marked.items()}
    line(
        "points watched, median / 5th percentile, %",
        (_spread(part, "watched", lowest=True) for part in watched.values()),
    )
    flat = {
        name: [row for row in part if float(row["plane"]) >= 100 * PLANE_SHARE]
        for name, part in marked.items()
    }
    line(f"models {100 * PLANE_SHARE:.0f} % of which is plane", (str(len(part)) for part in flat.values()))
    line(
        "their plane patches off planes by at most .005 %, RMS",
        (str(sum(float(row["off_plane"]) <= 0.005 for row in part)) for part in flat.values()),
    )
    line(
        "the same, median / 95th percentile, %",
        (_spread(part, "off_plane") for part in flat.values()),
    )
    for title, words in (("visible", "visible share, median / 95th percentile, %"),
                         ("off_plane", "plane patches of all models off planes, RMS, median / 95th percentile, %"),
                         ("embed_seconds", "embedding, median / 95th percentile, s"),
                         ("extract_seconds", "extraction as written, median / 95th percentile, s")):  # fmt: skip
        line(words, (_spread(part, title) for part in marked.values()))
    answers = ("outcome", *CHANGES, *CERTIFIED, "unmarked", "wrong key")
    everything = [row[title] for row in rows for title in answers]
    nothing = [row[title] for row in rows for title in ("unmarked", "wrong key") if row[title]]
    lines += [
        "",
        f"Wrong ids: {everything.count('wrong id')}. Present without a mark: "
        f"{sum(each not in ('absent', 'inconclusive') for each in nothing)} of {len(nothing)}.",
    ]
    return "\n".join(lines)


def _share(rows: Sequence[dict[str, str]], title: str, wanted: str = "id") -> str:
    told = [row[title] for row in rows if row[title]]
    tried = told if title == "both layers" else [each for each in told if not each.startswith("refused")]
    return f"{sum(each == wanted for each in tried)} of {len(tried)}" if tried else "-"


def _spread(rows: Sequence[dict[str, str]], title: str, *, lowest: bool = False) -> str:
    values = [float(row[title]) for row in rows]
    if not values:
        return "-"
    digits = 4 if title == "off_plane" else 2
    return f"{np.median(values):.{digits}f} / {np.quantile(values, 0.05 if lowest else 0.95):.{digits}f}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure what is left, and print the tables."""
    options = parser_of(__doc__, 40).parse_args(arguments)
    print(tables(measure(options, COLUMNS, models_of([options.split]), row_of)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
