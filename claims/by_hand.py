"""What meshmark does by hand beside the library that could do it: CPU seconds, their ratio, and what differs.

    python -m claims.by_hand

Each pair is measured in turns within one run, the best of three turns each; a ratio above 1 means that ours is
faster. Closest points need libigl (`pip install libigl`), which meshmark does not; without it they are left out.

Figures of docs/decisions/0015-by-hand-or-library.md.
"""

from __future__ import annotations

import io
import re
import tempfile
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any

import fast_simplification
import numpy as np

from meshmark.data import hare_ply
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.view import three_quarter_view
from meshmark.geometry.weld import weld
from meshmark.io import read_mesh, read_mesh_from, write_mesh
from meshmark.io.text.number_printing import format_numbers, round_numbers
from meshmark.io.text.number_style import NumberStyle
from meshmark.io.text.numbers import compact, parse_floats, parse_ints
from meshmark.io.text.tokens import tokenise
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.recovery.simplify import simplify
from meshmark.report.picture import CLAY, Panel, render

NUMBERS = 1_500_000
TURNS = 3
STYLES = {
    "%.6f": NumberStyle(kind="fixed", significant=7, decimals=6, least=6, exponents=False, upper=False),
    "%.9g": NumberStyle(kind="general", significant=9, decimals=9, least=0, exponents=True, upper=False),
    "%r": NumberStyle(kind="shortest", significant=17, decimals=17, least=1, exponents=True, upper=False),
}
DIGITS = {"%.6f": 6, "%.9g": 9, "%r": 17}


def compare(what: str, ours: Callable[[], Any], library: Callable[[], Any]) -> tuple[Any, Any]:
    """Print the times of both, taken in turns, and return what they gave."""
    best, results = [np.inf, np.inf], [None, None]
    for _ in range(TURNS):
        for i, call in enumerate((ours, library)):
            start = time.process_time()
            results[i] = call()
            best[i] = min(best[i], time.process_time() - start)
    print(f"{what:<44} ours {best[0]:6.3f} s   library {best[1]:6.3f} s   ratio {best[1] / best[0]:5.2f}")
    return results[0], results[1]


def note(text: str) -> None:
    print(f"    {text}", flush=True)


def joined(template: str, values: Any) -> bytes:
    """Return one number per line by Python's `%`, all in one operation."""
    return ((template + "\n") * len(values) % tuple(values.tolist())).encode("ascii")


def spans(text: bytes) -> tuple[Any, IntArray, IntArray]:
    letters = np.frombuffer(text, np.uint8)
    ends = np.flatnonzero(letters == ord("\n"))
    return letters, np.concatenate([[0], ends[:-1] + 1]), ends


def numbers_read(rng: np.random.Generator) -> None:
    """numpy's parser is what ours falls back to: the same values and the same refusals."""
    for template in ("%.6f", "%.9g", "%r", "%d"):
        whole = template == "%d"
        values = rng.integers(0, 500_000, NUMBERS) if whole else rng.normal(size=NUMBERS)
        letters, starts, ends = spans(joined(template, values))
        parse: Any = parse_ints if whole else parse_floats
        kind = np.int64 if whole else np.float64

        def by_numpy(letters=letters, starts=starts, ends=ends, kind=kind) -> Any:
            return np.fromstring(compact(letters, starts, ends).tobytes(), dtype=kind, sep=" ")

        ours, theirs = compare(
            f"1.5 M numbers as {template}, numpy.fromstring",
            lambda p=parse, t=letters, s=starts, e=ends: p(t, s, e),
            by_numpy,
        )
        note(f"same values: {np.array_equal(ours, theirs)}")


def numbers_written(rng: np.random.Generator) -> None:
    values = rng.normal(size=NUMBERS)
    for template, style in STYLES.items():
        rounded = round_numbers(style, DIGITS[template], values)

        def by_percent(template=template, rounded=rounded) -> tuple[Any, Any]:
            letters, starts, ends = spans(joined(template, rounded))
            return letters[letters != ord("\n")], ends - starts

        ours, theirs = compare(
            f"1.5 M numbers written as {template}, Python's %",
            lambda s=style, t=template, r=rounded: format_numbers(s, DIGITS[t], r),
            by_percent,
        )
        note(f"same characters: {all(map(np.array_equal, ours, theirs))}")


def grid(side: int) -> Mesh:
    """Return a wavy sheet of side x side points."""
    u, v = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    points = np.stack([u, v, 9.0 * np.sin(u / 41.0) * np.cos(v / 29.0)], axis=2).reshape(-1, 3) / side
    corner = (u[:-1, :-1] * side + v[:-1, :-1]).ravel()
    faces = np.stack(
        [corner, corner + side, corner + 1, corner + 1, corner + side, corner + side + 1], axis=1
    )
    return Mesh(np.round(points, 6), faces.reshape(-1, 3))


def whole_files() -> None:
    """How long an OBJ of half a million points takes, all of it, and its words alone."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sheet.obj"
        write_mesh(grid(707), path)
        start = time.process_time()
        mesh = read_mesh(path)
        read = time.process_time()
        write_mesh(mesh.with_vertices(mesh.vertices + 1e-3), path.with_name("patched.obj"))
        written = time.process_time()
        print(f"an OBJ of 499,849 points: read {read - start:.2f} s, patched {written - read:.2f} s")
        content = path.read_bytes()
    word = re.compile(rb"\S+")
    ours, theirs = compare(
        "its words as byte spans, re.finditer",
        lambda: tokenise(content),
        lambda: [match.span() for match in word.finditer(content)],
    )
    note(f"same spans: {list(zip(ours.starts.tolist(), ours.ends.tolist(), strict=True)) == theirs}")


def queries(
    points: FloatArray, faces: IntArray, rng: np.random.Generator
) -> Iterator[tuple[str, FloatArray]]:
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    middles = points[faces].mean(axis=1)
    yield "near the surface", middles + 1e-3 * size * rng.normal(size=middles.shape)
    yield "far off", points.mean(axis=0) + size * rng.normal(size=(20_000, 3))
    yield "at its own points", points


def closest_points(points: FloatArray, faces: IntArray, rng: np.random.Generator) -> None:
    if find_spec("igl") is None:
        print("closest points are left out: libigl is not installed (pip install libigl)")
        return
    import igl

    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    for name, places in queries(points, faces, rng):
        ours, theirs = compare(
            f"{len(places)} closest points {name}, libigl",
            lambda p=places: SurfaceIndex(points, faces).nearest(p),
            lambda p=places: igl.point_mesh_squared_distance(p, points, faces),
        )
        apart = np.abs(ours.distances - np.sqrt(theirs[0])).max() / size
        note(
            f"distances within {apart:.1e} of the diagonal; same face {(ours.faces == theirs[1]).mean():.1%}"
        )
    corners = rng.random((400, 1, 3)) + 0.2 * rng.normal(size=(400, 3, 3))
    corners[::2, 2] = corners[::2, 0] + rng.random((200, 1)) * (corners[::2, 1] - corners[::2, 0])
    flat, triples = corners.reshape(-1, 3), np.arange(1200).reshape(-1, 3)
    places = rng.random((3000, 3))
    for scale in (1.0, 1e-170, 1e160):
        ours = SurfaceIndex(scale * flat, triples).nearest(scale * places).distances
        theirs = np.sqrt(igl.point_mesh_squared_distance(scale * places, scale * flat, triples)[0])
        off = (theirs - ours) / scale
        note(
            f"half the triangles without area, unit {scale:g}: libigl's distance is up to "
            f"{max(-off.min(), 0.0):.2g} too short and up to {max(off.max(), 0.0):.2g} too long, "
            f"mean of ours {ours.mean() / scale:.2g}"
        )


def open_sides(faces: IntArray) -> int:
    """Return how many edges do not have two faces."""
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return int((np.unique(sides, axis=0, return_counts=True)[1] != 2).sum())


def miniatures(points: FloatArray, faces: IntArray) -> None:
    def by_library(count: int) -> tuple[FloatArray, IntArray]:
        middle, size = points.mean(axis=0), float(np.ptp(points, axis=0).max()) / 2000.0
        moved, left = fast_simplification.simplify(
            (points - middle) / size, faces.astype(np.int32), target_count=2 * count
        )
        left = left.astype(np.int64)
        return moved * size + middle, left[(left != np.roll(left, 1, axis=1)).all(axis=1)]

    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    for count in (500, 200, 80):
        both = compare(
            f"collapse to {count} points, fast-simplification",
            lambda n=count: simplify(points, faces, n),
            lambda n=count: by_library(n),
        )
        for name, (left, triples) in zip(("ours", "library"), both, strict=True):
            used = np.unique(triples)
            away = SurfaceIndex(left, triples).nearest(points).distances
            rms = float(np.sqrt((away**2).mean())) / diagonal
            note(
                f"{name}: {len(used)} points, RMS distance {rms:.3%} and largest {away.max() / diagonal:.2%} of "
                f"the diagonal, {open_sides(triples)} edges with other than two faces"
            )


def pictures(points: FloatArray, faces: IntArray) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    view = three_quarter_view(points)
    panel = Panel(caption="", points=points, faces=faces, colours=np.tile(CLAY, (len(points), 1)))

    def by_matplotlib() -> bytes:
        figure = plt.figure(figsize=(6.4, 6.4), dpi=100)
        axes: Any = figure.add_subplot(projection="3d")
        axes.plot_trisurf(*points.T, triangles=faces)
        out = io.BytesIO()
        figure.savefig(out, format="png")
        plt.close(figure)
        return out.getvalue()

    compare(f"a picture of {len(faces)} faces, matplotlib", lambda: render(panel, 640, view), by_matplotlib)


def main() -> int:
    """Print all comparisons."""
    rng = np.random.default_rng(0)
    surface = weld(read_mesh_from(BytesIO(hare_ply()), "ply"))
    numbers_read(rng)
    numbers_written(rng)
    whole_files()
    closest_points(surface.points, surface.faces, rng)
    miniatures(surface.points, surface.faces)
    pictures(surface.points, surface.faces)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
