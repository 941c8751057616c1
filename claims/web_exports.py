"""Marked models after what web pipelines do to a GLB: is the id read, is the export told from an edit?

python -m claims.web_exports FOLDER --node NODE [--limit N] [--skip N] [--forms FORM ...] [--edits N]
    [--tolerance NAME] [--least 2500] [--most 60000]

FOLDER holds models, in any depth; those of 2,500 to 60,000 points are taken in a seeded order, written as GLB and
marked with the default options. Each marked file goes through the tools below; of each copy the id is read and
the file authenticated. Then the copy itself is edited on 2 % of its points, in as many ways as `--edits` says, as
far as its own grid can hold that, and authenticated again.

NODE is a folder after `npm install --prefix NODE @gltf-transform/cli@4.5 gltfpack gltf-pipeline`.
Exit code 1 where an id is missed, a copy is called altered, an edit is not, or a form's median IoU is below .75.

Figures of docs/decisions/0023-tolerance-web.md.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from zlib import crc32

import numpy as np

import meshmark as mm
from claims.models import load
from meshmark.attacks.attack import Given
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.metrics.tamper import iou

KEY = mm.Key(bytes(range(32)))
FORMS = {
    "quantize": ("gltf-transform", "quantize", "IN", "OUT"),
    "quantize scene": ("gltf-transform", "quantize", "IN", "OUT", "--quantization-volume", "scene"),
    "meshopt": ("gltf-transform", "meshopt", "IN", "OUT"),
    "optimize": ("gltf-transform", "optimize", "IN", "OUT", "--texture-compress", "false"),
    "gltfpack -c": ("gltfpack", "-i", "IN", "-o", "OUT", "-c"),
    "draco 14": ("gltf-transform", "draco", "IN", "OUT"),
    "draco 12": ("gltf-pipeline", "-i", "IN", "-o", "OUT", "-d", "--draco.quantizePositionBits", "12"),
    "draco 11": ("gltf-pipeline", "-i", "IN", "-o", "OUT", "-d"),
}
EDITS = ("bump", "dent", "move_part", "scale_part", "smooth_part", "replace_part", "delete_part")
SHARE = 0.02
ENDINGS = (".xz", ".glb", ".gltf", ".obj", ".ply", ".off", ".stl")
LEAST_IOU = 0.75


@dataclass(frozen=True, kw_only=True)
class Row:
    """One copy, or one edit of it (IoU None: no edit)."""

    model: str
    points: int
    form: str
    edit: str
    read: bool
    verdict: str
    share: float
    overlap: float | None
    said: str


def subjects(folder: Path, least: int, most: int) -> Iterator[tuple[str, Mesh]]:
    """Yield the names and meshes of the models of `least` to `most` points, in a seeded order."""
    paths = sorted(path for path in folder.rglob("*") if path.suffix in ENDINGS)
    for place in np.random.default_rng(23).permutation(len(paths)):
        path = paths[place]
        mesh = load(path) if path.suffix == ".xz" else mm.read_mesh(path)
        if least <= len(surface_of(mesh).points) <= most:
            yield path.name.split(".")[0], mesh


def rows_of(name: str, mesh: Mesh, options: argparse.Namespace, folder: Path) -> Iterator[Row]:
    """Mark a model, put it through the tools and yield what is read in each copy."""
    plain, marked = folder / "plain.glb", folder / "marked.glb"
    mm.write_mesh(mesh, plain)
    start = perf_counter()
    try:
        made = mm.embed_file(plain, marked, KEY, id=crc32(name.encode()), tolerance=options.tolerance)
    except CapacityError as error:
        print(f"{name}: refused: {error}")
        return
    points = len(surface_of(made.mesh).points)
    print(
        f"{name}: {points} points, {made.layers}, {made.mark_vertices} marks, {made.payload_bytes} payload bytes, "
        f"{made.psnr_db:.1f} dB, {perf_counter() - start:.1f} s; {'; '.join(made.remarks)}",
        flush=True,
    )
    rng = np.random.default_rng(crc32(name.encode()))
    for form in options.forms:
        copy = folder / "copy.glb"
        copy.unlink(missing_ok=True)
        tool, *line = FORMS[form]
        names = {"IN": str(marked), "OUT": str(copy)}
        command = [str(options.node / "node_modules/.bin" / tool), *(names.get(word, word) for word in line)]
        done = subprocess.run(command, capture_output=True, check=False)
        if not copy.exists():
            print(f"{name}: {form} made no file: {done.stderr[-300:]!r}")
            continue
        exported = mm.read_mesh(copy)
        found, read = mm.authenticate(exported, KEY), mm.extract(exported, KEY).id == made.id
        yield Row(
            model=name,
            points=points,
            form=form,
            edit="",
            read=read,
            verdict=found.verdict,
            share=found.altered_area_fraction,
            overlap=None,
            said=found.advice,
        )
        for edit in rng.permutation(EDITS)[: options.edits]:
            try:
                attacked = mm.ATTACKS[edit].apply(exported, SHARE, rng, Given())
            except InputError as error:
                print(f"{name}: {edit}: {error}")
                continue
            changed = attacked.mesh
            if len(changed.vertices) == len(exported.vertices) and exported.document is not None:
                changed = changed.with_vertices(exported.document.conform(changed.vertices))
            found = mm.authenticate(changed, KEY)
            truth = attacked.altered
            assert truth is not None
            yield Row(
                model=name,
                points=points,
                form=form,
                edit=str(edit),
                read=found.id == made.id,
                verdict=found.verdict,
                share=found.altered_area_fraction,
                overlap=iou(truth, found.altered),
                said=found.advice,
            )


def main() -> int:
    """Print a line a copy and the table of forms."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--node", type=Path, required=True)
    parser.add_argument("--limit", type=int, default=8)
    parser.add_argument("--skip", type=int, default=0)
    parser.add_argument("--forms", nargs="+", choices=FORMS, default=list(FORMS), metavar="FORM")
    parser.add_argument("--edits", type=int, default=2, help="edits of each copy")
    parser.add_argument("--tolerance", default=None)
    parser.add_argument("--least", type=int, default=2500)
    parser.add_argument("--most", type=int, default=60000)
    options = parser.parse_args()
    options.node = options.node.resolve()
    rows: list[Row] = []
    with tempfile.TemporaryDirectory(prefix="meshmark-") as folder:
        for number, (name, mesh) in enumerate(subjects(options.folder, options.least, options.most)):
            if number < options.skip:
                continue
            if number == options.skip + options.limit:
                break
            for row in rows_of(name, mesh, options, Path(folder)):
                rows.append(row)
                overlap = "" if row.overlap is None else f" IoU {row.overlap:.2f}"
                print(
                    f"  {row.form:15} {row.edit:12} id {'yes' if row.read else 'NO '} {row.verdict:12} "
                    f"{100 * row.share:6.2f} %{overlap}  {row.said[:110]}",
                    flush=True,
                )
    return report(rows)


def report(rows: list[Row]) -> int:
    """Print the table of forms; return 1 where something is outside its bar."""
    by_form: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        by_form[row.form].append(row)
    print("| form | copies | id read | not altered | edits | altered | IoU median | IoU >= .75 |")
    print("|---|---|---|---|---|---|---|---|")
    bad = not rows
    for form, some in by_form.items():
        copies = [row for row in some if row.overlap is None]
        edits = [row for row in some if row.overlap is not None]
        overlaps = np.array([row.overlap for row in edits if row.overlap is not None] or [0.0])
        read, intact = sum(row.read for row in copies), sum(row.verdict != "altered" for row in copies)
        called = sum(row.verdict == "altered" for row in edits)
        print(
            f"| {form} | {len(copies)} | {read} | {intact} | {len(edits)} | {called} | "
            f"{np.median(overlaps):.2f} | {(overlaps >= LEAST_IOU).sum()} |"
        )
        bad = bad or read < len(copies) or intact < len(copies) or called < len(edits)
        bad = bad or (bool(edits) and float(np.median(overlaps)) < LEAST_IOU)
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
