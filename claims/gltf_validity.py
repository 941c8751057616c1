"""Does Khronos' validator say anything about our files that it did not say about the originals?

Run: python -m claims.gltf_validity. Reads every .glb and .gltf in ../shared/data that can be read,
moves every vertex a little, writes, and runs `tools/validate_gltf.mjs` on both. Needs node and
`npm install --prefix tools`.

No page quotes its figures yet; docs/claims.md says what it prints.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from meshmark.errors import InputError
from meshmark.io.gltf.parse import GltfDocument, parse_glb, parse_gltf

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"


def read(path: Path) -> GltfDocument | None:
    """Return the document, or None where the file is refused or shows no surface."""
    try:
        return (parse_glb if path.suffix.lower() == ".glb" else parse_gltf)(path.read_bytes(), path)
    except InputError:
        return None


def write_moved(document: GltfDocument, path: Path, folder: Path) -> Path:
    """Write the model, every vertex moved by about 1e-4 of its size, and what it refers to."""
    folder.mkdir()
    size = float(np.ptp(document.vertices, axis=0).max()) or 1.0
    noise = np.random.default_rng(1).normal(size=document.vertices.shape) * size * 1e-4
    for name, content in document.patched(document.vertices + noise, path.name).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    for side in document.side_files():
        target = folder / side.relative_to(path.parent)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(side.read_bytes())
    return folder / path.name


def messages(paths: list[Path]) -> list[Counter[Any]]:
    """Return, per file, how often the validator says what about which part."""
    command = ["node", str(ROOT / "tools" / "validate_gltf.mjs"), *map(str, paths)]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    reports = [json.loads(line)["messages"] for line in lines]
    return [Counter((item["code"], item.get("pointer")) for item in report) for report in reports]


def main() -> int:
    """Print one line per file with new messages and a summary; return 1 if there is any."""
    paths = [path for path in sorted(DATA.rglob("*")) if path.suffix.lower() in (".glb", ".gltf")]
    documents = {path: document for path in paths if (document := read(path)) is not None}
    with tempfile.TemporaryDirectory() as folder:
        written, refused = {}, 0
        for number, (path, document) in enumerate(documents.items()):
            try:
                written[path] = write_moved(document, path, Path(folder) / str(number))
            except InputError as error:
                refused += 1
                print(f"{path.relative_to(DATA)}: {error}")
        before, after = messages(list(written)), messages(list(written.values()))
    worse = 0
    for path, old, new in zip(written, before, after, strict=True):
        if fresh := new - old:
            worse += 1
            print(f"{path.relative_to(DATA)}: {dict(fresh)}")
    print(
        f"{len(paths)} files, {len(documents)} readable, {refused} cannot be moved, {len(written)} written: "
        f"{worse} with messages that the original did not have"
    )
    return int(worse > 0)


if __name__ == "__main__":
    sys.exit(main())
