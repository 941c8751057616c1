"""Which models are measured: the first that `embed` accepts, in an order that nobody chose."""

from __future__ import annotations

import hashlib
from pathlib import Path

from claims.compressed_gltf.store import Model, append, load
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, MeshmarkError
from meshmark.marking.marked_file import embed_file

__all__ = ["KEY", "candidates", "marked_models"]

KEY = Key(bytes(range(32)))


def candidates(folder: Path) -> list[tuple[str, Path]]:
    """Return the SHA-256 of each GLB's bytes and its path, in the order of the digests; equal files once."""
    found = {hashlib.sha256(path.read_bytes()).hexdigest(): path for path in sorted(folder.rglob("*.glb"))}
    return sorted(found.items())


def marked_models(folder: Path, store: Path, count: int) -> list[Model]:
    """Mark models with the default options until `count` are marked; return all that were tried.

    The marked files lie in the folder `store` under the digests of the originals.
    """
    rows = store / "models.jsonl"
    tried = {row.digest: row for row in load(rows, Model)}
    seen: list[Model] = []
    for digest, path in candidates(folder):
        if sum(not row.refused for row in seen) == count:
            break
        if digest not in tried:
            tried[digest] = _marked(digest, path, store, path.relative_to(folder).as_posix())
            append(rows, tried[digest])
            print(f"{tried[digest].name}: {tried[digest].message or 'marked'}", flush=True)
        seen.append(tried[digest])
    return seen


def _marked(digest: str, path: Path, store: Path, name: str) -> Model:
    identity, refused, message = "", "", ""
    out = store / f"{digest}.glb"
    out.unlink(missing_ok=True)  # of an interrupted run
    try:
        identity = f"{embed_file(path, out, KEY).id:016x}"
    except CapacityError as error:
        refused, message = "capacity", str(error)
    except MeshmarkError as error:
        refused, message = "other", str(error)
    return Model(digest=digest, name=name, id=identity, refused=refused, message=message)
