"""Compressed copies of marked models: is the id back, is what is decoded what the reference decoders give?"""

from __future__ import annotations

import base64
import json
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from claims.compressed_gltf.models import KEY
from claims.compressed_gltf.store import Copy, Model, append, load
from meshmark.io import read_mesh
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.parse import parse_glb
from meshmark.marking import extract

__all__ = ["FORMS", "copy_path", "measure_copies", "table"]

DECODE = Path(__file__).resolve().parents[2] / "tools" / "decode_gltf.mjs"
FORMS = {
    "draco": ("gltf-transform", "draco", "IN", "OUT"),
    "meshopt": ("gltf-transform", "meshopt", "IN", "OUT"),
    "meshopt 12 bits": ("gltf-transform", "meshopt", "IN", "OUT", "--quantize-position", "12"),
    "gltfpack -c": ("gltfpack", "-i", "IN", "-o", "OUT", "-c"),
    "gltfpack -cc -vpf": ("gltfpack", "-i", "IN", "-o", "OUT", "-cc", "-vpf"),
    "gltfpack -cz (KHR)": ("gltfpack", "-i", "IN", "-o", "OUT", "-cz"),
}


def copy_path(store: Path, digest: str, form: str) -> Path:
    """Return where the copy of a model in one form lies."""
    return store / f"{digest}.{form.replace(' ', '_')}.glb"


def measure_copies(models: Iterable[Model], forms: list[str], node: Path, store: Path) -> list[Copy]:
    """Return a row for each model and form; those that the store has are not made again."""
    path = store / "copies.jsonl"
    done = {(row.digest, row.form): row for row in load(path, Copy)}
    rows = []
    for model in models:
        for form in forms:
            key = (model.digest, form)
            if key not in done:
                done[key] = _measured(model, form, node, store)
                append(path, done[key])
                print(done[key], flush=True)
            rows.append(done[key])
    return rows


def _measured(model: Model, form: str, node: Path, store: Path) -> Copy:
    source, out = store / f"{model.digest}.glb", copy_path(store, model.digest, form)
    tool, *line = FORMS[form]
    names = {"IN": str(source), "OUT": str(out)}
    command = [str(node / "node_modules" / ".bin" / tool), *(names.get(word, word) for word in line)]
    subprocess.run(command, capture_output=True, check=False)
    equal = found = False
    if out.exists():
        equal = _decoded(parse_glb(out.read_bytes(), out).container) == _reference(out, node)
        found = extract(read_mesh(out), KEY).id == int(model.id, 16)
    return Copy(
        digest=model.digest,
        name=model.name,
        form=form,
        made=out.exists(),
        equal=equal,
        found=found,
        before=source.stat().st_size,
        after=out.stat().st_size if out.exists() else 0,
    )


def _reference(file: Path, node: Path) -> Any:
    """Return what the reference decoders give for a file."""
    command = ["node", "--input-type=module", "-", str(file.resolve())]
    done = subprocess.run(
        command, cwd=node, input=DECODE.read_text(), capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


def _decoded(container: Container) -> list[Any]:
    """Return the same from our decoder."""
    return [
        {
            "indices": _code(_rows(container, item["indices"]).astype("<u4")),
            "attributes": {name: _code(_rows(container, at)) for name, at in item["attributes"].items()},
        }
        for mesh in container.tables["meshes"]
        for item in mesh["primitives"]
    ]


def _rows(container: Container, accessor: int) -> NDArray[Any]:
    return np.ascontiguousarray(open_accessor(container, accessor).raw(container.blob))


def _code(rows: NDArray[Any]) -> str:
    return base64.b64encode(rows.tobytes()).decode()


def table(rows: list[Copy]) -> str:
    """Return a line per form: copies made, ids back, copies equal to the last bit, size over that of the input."""
    lines = [f"{'form':20} {'files':>5} {'made':>5} {'id back':>8} {'equal to the bit':>17} {'size':>6}"]
    for form in dict.fromkeys(row.form for row in rows):
        own = [row for row in rows if row.form == form]
        made, found, equal = (sum(getattr(row, name) for row in own) for name in ("made", "found", "equal"))
        share = sum(row.after for row in own) / sum(row.before for row in own if row.made) if made else 0
        lines.append(f"{form:20} {len(own):5} {made:5} {found:8} {equal:17} {share:6.2f}")
    return "\n".join(lines)
