"""Are marks found in compressed copies, are these decoded to the last bit, and does a broken stream do no harm?

Run: python -m claims.compressed_gltf FOLDER --node NODE [--hostile 5]. FOLDER holds plain GLBs. Each is marked,
and the marked file compressed by common tools in each of the forms of `FORMS`; of each form the table says in how
many files the id was found, and in how many every index and attribute is what the reference decoders give. From
compressed files broken ones are made; what reading them does is counted and its time and memory measured.

NODE is a folder after `npm install --prefix NODE @gltf-transform/cli@4.5 gltfpack meshoptimizer draco3dgltf`.
Exit code 1 where an id is missed, a bit differs, or a broken file crashes, takes over 30 s or over 1 GB.

Figures of docs/decisions/0002-compressed-gltf.md.
"""

from __future__ import annotations

import argparse
import base64
import json
import struct
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.parse import parse_glb
from meshmark.marking import extract
from meshmark.marking.marked_file import embed_file
from meshmark.mesh import Mesh

DECODE = Path(__file__).resolve().parents[1] / "tools" / "decode_gltf.mjs"
KEY = Key(bytes(range(32)))
FORMS = {
    "draco": ("gltf-transform", "draco", "IN", "OUT"),
    "meshopt": ("gltf-transform", "meshopt", "IN", "OUT"),
    "meshopt 12 bits": ("gltf-transform", "meshopt", "IN", "OUT", "--quantize-position", "12"),
    "gltfpack -c": ("gltfpack", "-i", "IN", "-o", "OUT", "-c"),
    "gltfpack -cc -vpf": ("gltfpack", "-i", "IN", "-o", "OUT", "-cc", "-vpf"),
    "gltfpack -cz (KHR)": ("gltfpack", "-i", "IN", "-o", "OUT", "-cz"),
}
SECONDS, MEGABYTES = 30.0, 1024

# Reads one file in a fresh process; prints how it went, the peak memory of both processes in MB, and the seconds.
PROBE = """
import resource, sys, time
from meshmark.errors import InputError
from meshmark.io import read_mesh
start = time.perf_counter()
try:
    read_mesh(sys.argv[1])
    said = "read"
except InputError as error:
    said = "refused"
    assert str(error) and "\\n" not in str(error)
peaks = [resource.getrusage(who).ru_maxrss // 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
print(said, *peaks, time.perf_counter() - start)
"""


@dataclass
class Row:
    """What was seen of one form."""

    files: int = 0
    found: int = 0
    equal: int = 0
    before: int = 0
    after: int = 0
    messages: list[str] = field(default_factory=list)


def marked(source: Path, folder: Path) -> tuple[Path, int] | None:
    """Mark a model; None where it cannot carry the id."""
    out = folder / source.name
    try:
        return out, embed_file(source, out, KEY, layers="ownership").id
    except MeshmarkError as error:
        print(f"{source.name}: {error}")
        return None


def compressed(model: Path, form: str, node: Path) -> Path | None:
    """Return the model compressed in one form, None where the tool fails."""
    out = model.with_name(f"{model.stem}.{form.replace(' ', '_')}.glb")
    tool, *line = FORMS[form]
    names = {"IN": str(model), "OUT": str(out)}
    command = [str(node / "node_modules" / ".bin" / tool), *(names.get(word, word) for word in line)]
    subprocess.run(command, capture_output=True, check=False)
    return out if out.exists() else None


def reference(files: list[Path], node: Path) -> list[Any]:
    """Return what the reference decoders give for each file."""
    command = ["node", "--input-type=module", "-", *map(str, files)]
    done = subprocess.run(
        command, cwd=node, input=DECODE.read_text(), capture_output=True, text=True, check=True
    )
    return [json.loads(line) for line in done.stdout.splitlines()]


def decoded(container: Container) -> list[Any]:
    """Return the same from our decoder."""
    rows = lambda index: np.ascontiguousarray(open_accessor(container, index).raw(container.blob))  # noqa: E731
    code = lambda array: base64.b64encode(array.tobytes()).decode()  # noqa: E731
    return [
        {
            "indices": code(rows(item["indices"]).astype("<u4")),
            "attributes": {name: code(rows(index)) for name, index in item["attributes"].items()},
        }
        for mesh in container.tables["meshes"]
        for item in mesh["primitives"]
    ]


def broken(data: bytes, count: int, rng: np.random.Generator) -> Iterator[bytes]:
    """Yield `count` files of each kind: bits flipped in streams, streams cut off, absurd counts."""
    size = struct.unpack_from("<I", data, 12)[0]
    tree, body = json.loads(data[20 : 20 + size]), bytearray(data[28 + size :])
    for _ in range(count):
        flipped = body.copy()
        for place in rng.integers(0, len(flipped), int(rng.integers(1, 20))):
            flipped[place] ^= 1 << int(rng.integers(0, 8))
        yield _glb(tree, flipped)
        start = int(rng.integers(0, len(body)))
        yield _glb(tree, body[:start] + bytes(len(body) - start))
        changed = json.loads(json.dumps(tree))
        records = [entry for entry in _records(changed) if "count" in entry or "byteLength" in entry]
        for entry in rng.choice(np.array(records, dtype=object), 3):
            for key in ("count", "byteLength", "byteStride"):
                if key in entry:
                    entry[key] = int(entry[key] * rng.choice([0.5, 2, 10, 1000, 1e6]))
        yield _glb(changed, body)


def _records(part: Any) -> list[dict[str, Any]]:
    if isinstance(part, list):
        return [entry for item in part for entry in _records(item)]
    return (
        [part, *(entry for item in part.values() for entry in _records(item))]
        if isinstance(part, dict)
        else []
    )


def _glb(tree: Any, body: bytes | bytearray) -> bytes:
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(body), len(text), b"JSON")
    return head + text + struct.pack("<I4s", len(body), b"BIN\0") + bytes(body)


def probe(data: bytes, path: Path) -> tuple[str, int, int, float]:
    """Read a broken file in a process of its own: how it went, MB of reader and decoder, seconds."""
    path.write_bytes(data)
    done = subprocess.run(
        [sys.executable, "-c", PROBE, str(path)], capture_output=True, text=True, check=False
    )
    if done.returncode:
        return f"crash ({done.stderr.strip().splitlines()[-1:]})", 0, 0, 0.0
    said, own, child, seconds = done.stdout.split()
    return said, int(own), int(child), float(seconds)


def measure_forms(
    paths: list[Path], forms: list[str], node: Path, folder: Path
) -> tuple[dict[str, Row], list[Path]]:
    """Return a row per form, and all compressed files."""
    rows: dict[str, Row] = defaultdict(Row)
    made = []
    for source in paths:
        model = marked(source, folder)
        for form in forms if model is not None else ():
            assert model is not None
            print(f"{source.name}, {form}", end="\r", file=sys.stderr, flush=True)
            out = compressed(model[0], form, node)
            if out is None:
                rows[form].messages.append(f"{source.name}: the tool fails")
                continue
            made.append(out)
            row, document = rows[form], parse_glb(out.read_bytes(), out)
            row.files += 1
            row.before, row.after = row.before + model[0].stat().st_size, row.after + out.stat().st_size
            equal = decoded(document.container) == reference([out], node)[0]
            found = extract(Mesh(document.vertices, document.faces), KEY).id == model[1]
            row.equal, row.found = row.equal + equal, row.found + found
            if not (equal and found):
                print(f"{source.name}, {form}: equal {equal}, id back {found}", flush=True)
    return dict(rows), made


def measure_hostile(files: list[Path], count: int, folder: Path) -> bool:
    """Print what reading broken files does; return whether all stay within the limits."""
    rng, seen = np.random.default_rng(1), Counter[str]()
    most = np.zeros(3)
    for path in files:
        for data in broken(path.read_bytes(), count, rng):
            said, own, child, seconds = probe(data, folder / "broken.glb")
            if said not in ("read", "refused") or max(own, child) >= MEGABYTES or seconds >= SECONDS:
                print(f"{path.name}: {said}, {own} and {child} MB, {seconds:.1f} s", flush=True)
            seen[said] += 1
            most = np.maximum(most, [own, child, seconds])
    peaks = f"{most[0]:.0f} MB (reader), {most[1]:.0f} MB (decoder), {most[2]:.1f} s"
    print(f"broken files: {dict(seen)}; at most {peaks}")
    return (
        set(seen) <= {"read", "refused"} and most[0] < MEGABYTES and most[1] < MEGABYTES and most[2] < SECONDS
    )


def main() -> int:
    """Print the table and the line about broken files."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--node", type=Path, required=True)
    parser.add_argument("--forms", nargs="+", choices=FORMS, default=list(FORMS), metavar="FORM")
    parser.add_argument(
        "--hostile", type=int, default=5, help="broken files of each kind per compressed file"
    )
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        rows, made = measure_forms(
            sorted(given.folder.rglob("*.glb")), given.forms, given.node.resolve(), Path(name)
        )
        print(f"{'form':20} {'files':>5} {'id back':>8} {'equal to the bit':>17} {'size':>6}")
        for form, row in rows.items():
            share = row.after / row.before if row.before else 0
            print(f"{form:20} {row.files:5} {row.found:8} {row.equal:17} {share:6.2f}")
            print(*row.messages, sep="\n", end="\n" if row.messages else "")
        whole = all(row.found == row.equal == row.files for row in rows.values())
        safe = measure_hostile(made, given.hostile, Path(name)) if given.hostile else True
    return int(not (whole and safe))


if __name__ == "__main__":
    sys.exit(main())
