"""`meshmark demo`: the whole way on one model, from a key to an id read from a changed copy."""

from __future__ import annotations

import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.demo_damage import Places, damage
from meshmark.cli.extract import EXIT_CODES
from meshmark.cli.options import Force
from meshmark.cli.output import answer, percent, plural, say
from meshmark.cli.paths import check_output, make_folder
from meshmark.cli.progress import progress

if TYPE_CHECKING:
    from meshmark.coding.keys import Key
    from meshmark.marking import Embedding
    from meshmark.mesh import Mesh

__all__ = ["demo", "travelled"]

# Noise per coordinate, as a share of the mean distance of the vertices from their centroid.
NOISE = 0.001
SCALE, SEED = 2.5, 2026


def demo(
    model: Annotated[
        Path | None,
        typer.Argument(metavar="MODEL", help="Model to use instead of the hare that is included."),
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the files.")] = Path(
        "meshmark-demo"
    ),
    force: Force = False,
) -> int:
    """Show the whole way on one model.

    Mark it; turn, resize, move and roughen it; save it in another format; and read the id back. Saw it in half and
    read the id with its certificate. Edit it, find what was altered, and bring that back.
    Leaves the key, the models, a page and a picture in DIR, all of them at the end; a key that is there already is
    used. Exit code 0: the id came back.
    """
    from meshmark.io import Staging

    made = not out.exists()
    make_folder(out)
    try:
        with Staging(force, [] if model is None else [model]) as staging:
            return _shown(model, Places(out, staging.folder(out)), force)
    except BaseException:
        if made:
            with suppress(OSError):
                out.rmdir()
        raise


def _shown(model: Path | None, places: Places, force: bool) -> int:
    from meshmark.coding.chance import in_words
    from meshmark.coding.keys import Key
    from meshmark.coding.message import format_id
    from meshmark.io import read_mesh, write_mesh
    from meshmark.marking import extract
    from meshmark.marking.marked_file import embed_file
    from meshmark.report.demo_picture import demo_picture

    work, named = places.work, places.named
    original = _original(model, work)
    mesh = read_mesh(original)
    _refuse_taken(places, original.name, _changed_name(mesh), model, force)
    steps = _Steps()
    key = _key(places)
    steps.done("Key", f"{places.out / 'demo.key'}, secret, never shown")
    size = f"{plural(len(mesh.vertices), 'vertex/vertices')}, {plural(len(mesh.faces), 'face')}"
    steps.done("Model", f"{named(original)}: {size}")

    marked = original.with_name(original.name.replace("original", "marked", 1))
    with progress("marking"):
        embedded = embed_file(original, marked, key)
    identity = "none" if embedded.id is None else format_id(embedded.id)
    steps.done(
        "Marked",
        f"{named(marked)}: id {identity} in {embedded.carriers} places{_upper(embedded)}; moved "
        f"{percent(embedded.rms_over_diagonal)} of the diagonal RMS; read back and verified",
    )

    changed = work / _changed_name(mesh)
    away = travelled(read_mesh(marked))
    write_mesh(away, changed)
    steps.done(
        "Changed",
        f"{named(changed)}: turned, {SCALE} times as large, moved, {percent(NOISE)} noise, other format",
    )

    suspect = read_mesh(changed)
    with progress("looking for the mark"):
        found = extract(suspect, key)
    back = found.id == embedded.id
    chance = f"chance of a false alarm {in_words(found.log10_false_positive)}"
    steps.done("Read", f"with the key alone: {found.presence}{f', id {identity}; {chance}' if back else ''}")
    with progress("looking for the mark"):
        mismatch = extract(suspect, Key.generate())
    steps.done("Read", f"with another key: {mismatch.presence}")

    for remark in embedded.remarks:
        say(f"meshmark: {remark}")
    more = damage(marked, embedded, key, places, steps.done)
    picture = work / "demo.png"
    with progress("drawing"):
        demo_picture(mesh, embedded.mesh, away, picture, more)
    steps.done("Picture", f"{named(picture)}: all of these")
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


def _key(places: Places) -> Key:
    """Return the key of an earlier demo in the same folder, or a new one."""
    from meshmark.coding.keys import Key

    if (places.out / "demo.key").exists():
        return Key.load(places.out / "demo.key")
    key = Key.generate()
    key.save(places.work / "demo.key")
    return key


def _refuse_taken(places: Places, original: str, changed: str, model: Path | None, force: bool) -> None:
    """Raise `OutputError` where a file of an earlier demo, or the model, has a name that will be needed."""
    kinds = ("original", "marked", "edited", "recovered")
    names = [original.replace("original", kind, 1) for kind in kinds]
    names += [changed, "half.ply", "report.html", "demo.cert", "demo.png"]
    for name in names:
        check_output(places.out / name, [] if model is None else [model], force=force)


def _changed_name(mesh: Mesh) -> str:
    """Return the name of a file in another format than the model's."""
    return "changed.obj" if mesh.document is not None and mesh.document.format == "glb" else "changed.glb"


def _original(model: Path | None, out: Path) -> Path:
    """Put a copy of the model into the folder, and what it refers to."""
    from meshmark.data import hare_ply
    from meshmark.io import read_mesh, write_mesh

    if model is None:
        copy = out / "original.ply"
        copy.write_bytes(hare_ply())
        return copy
    packed = model.suffix.lower() == ".gz"
    extension = model.with_suffix("").suffix if packed else model.suffix
    copy = out / f"original{extension}{model.suffix if packed else ''}"
    write_mesh(read_mesh(model), copy)
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
