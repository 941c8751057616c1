"""`meshmark demo`: the whole way on one model, from a key to an id read from a changed copy."""

from __future__ import annotations

import sys
import time
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.demo_damage import damage
from meshmark.cli.extract import EXIT_CODES
from meshmark.cli.output import answer, percent, plural, say
from meshmark.cli.paths import make_folder
from meshmark.cli.progress import progress

if TYPE_CHECKING:
    from meshmark.coding.keys import Key
    from meshmark.mesh import Mesh
    from meshmark.schemes.ncdg_lv import Embedding

__all__ = ["demo", "travelled"]

# Noise per coordinate, as a share of the mean distance of the vertices from their centroid.
NOISE = 0.001
SCALE, SEED = 2.5, 2026


def demo(
    model: Annotated[
        Path | None,
        typer.Argument(metavar="MODEL", help="Model to use instead of the hare that comes along."),
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the files.")] = Path(
        "meshmark-demo"
    ),
) -> int:
    """Show the whole way on one model.

    Mark it; turn, resize, move and roughen it; save it in another format; and read the id back. Saw it in half and
    read the id with its certificate. Edit it, find what was altered, and bring that back.
    Leaves the key, the models, a page and a picture in DIR. Exit code 0: the id came back.
    """
    from meshmark.coding.keys import Key
    from meshmark.coding.message import format_id
    from meshmark.io import read_mesh, write_mesh
    from meshmark.report.demo import demo_picture
    from meshmark.schemes.ncdg_lv import extract
    from meshmark.schemes.ncdg_lv.files import embed_file

    steps = _Steps()
    make_folder(out)
    key = _key(out / "demo.key")
    steps.done("Key", f"{out / 'demo.key'}, secret, never shown")

    original = _original(model, out)
    mesh = read_mesh(original)
    size = f"{plural(len(mesh.vertices), 'vertex/vertices')}, {plural(len(mesh.faces), 'face')}"
    steps.done("Model", f"{original}: {size}")

    marked = original.with_name(original.name.replace("original", "marked", 1))
    with progress("marking"):
        embedded = embed_file(original, marked, key)
    identity = format_id(embedded.id)
    steps.done(
        "Marked",
        f"{marked}: id {identity} in {embedded.carriers} places{_upper(embedded)}; moved "
        f"{percent(embedded.rms_over_diagonal)} of the diagonal RMS; read back and verified",
    )

    changed = out / _changed_name(mesh)
    away = travelled(read_mesh(marked))
    write_mesh(away, changed)
    steps.done(
        "Changed", f"{changed}: turned, {SCALE} times as large, moved, {percent(NOISE)} noise, other format"
    )

    suspect = read_mesh(changed)
    with progress("looking for the mark"):
        found = extract(suspect, key)
    back = found.id == embedded.id
    chance = f"chance of a false alarm below 10^{found.log10_false_positive:.0f}"
    steps.done("Read", f"with the key alone: {found.presence}{f', id {identity}; {chance}' if back else ''}")
    with progress("looking for the mark"):
        stranger = extract(suspect, Key.generate())
    steps.done("Read", f"with another key: {stranger.presence}")

    for remark in embedded.remarks:
        say(f"meshmark: {remark}")
    more = damage(marked, embedded, key, out, steps.done)
    picture = out / "demo.png"
    with progress("drawing"):
        demo_picture(mesh, embedded.mesh, away, picture, more)
    steps.done("Picture", f"{picture}: all of these")
    answer("The id came back." if back else "The id did not come back.", {}, as_json=False)
    return 0 if back else EXIT_CODES[found.presence] or EXIT_CODES["absent"]


def _upper(embedded: Embedding) -> str:
    if not embedded.mark_vertices:
        return ""
    payload = plural(embedded.payload_bytes, "byte")
    return f", {plural(embedded.mark_vertices, 'mark')} of authentication, a payload of {payload}"


class _Steps:
    """Prints what was done, each time with the seconds since the last."""

    def __init__(self) -> None:
        self.last = time.perf_counter()

    def done(self, what: str, line: str) -> None:
        seconds = time.perf_counter() - self.last
        answer(f"{seconds:6.2f} s  {what:<8} {line}", {}, as_json=False)
        sys.stdout.flush()
        self.last = time.perf_counter()


def _key(path: Path) -> Key:
    """Return the key of an earlier demo in the same folder, or a new one."""
    from meshmark.coding.keys import Key

    if not path.exists():
        Key.generate().save(path)
    return Key.load(path)


def _changed_name(mesh: Mesh) -> str:
    """Return the name of a file in another format than the model's."""
    return "changed.obj" if mesh.document is not None and mesh.document.format == "glb" else "changed.glb"


def _original(model: Path | None, out: Path) -> Path:
    """Put a copy of the model into the folder, and what it refers to."""
    from meshmark.io import read_mesh, write_mesh

    with resources.as_file(resources.files("meshmark") / "data" / "hare.ply.gz") as hare:
        source = hare if model is None else model
        packed = source.suffix.lower() == ".gz"
        extension = source.with_suffix("").suffix if packed else source.suffix
        copy = out / f"original{extension}{source.suffix if packed and model is not None else ''}"
        write_mesh(read_mesh(source), copy)
    return copy


def travelled(mesh: Mesh) -> Mesh:
    """Return the mesh turned, `SCALE` times as large, elsewhere, and with uniform noise of share `NOISE`.

    Vertices that coincide stay together. The same input gives the same output.
    """
    import numpy as np
    from scipy.spatial.transform import Rotation

    from meshmark.geometry.weld import weld

    random = np.random.default_rng(SEED)
    welded = weld(mesh)
    points = welded.points - welded.points.mean(axis=0)
    radius = np.linalg.norm(points, axis=1).mean()
    noise = random.uniform(-NOISE, NOISE, points.shape) * radius
    turned = Rotation.from_euler("yxz", (140.0, -20.0, 25.0), degrees=True).apply(points + noise)
    return mesh.with_vertices((SCALE * turned + 3.0 * radius * random.normal(size=3))[welded.point_of_vertex])
