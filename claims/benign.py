"""What is promised to leave a marked model authentic, operation by operation, as other programs do it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from zlib import crc32

import numpy as np

from meshmark.attacks import ATTACKS
from meshmark.io import read_mesh, write_mesh
from meshmark.marking import Embedding
from meshmark.mesh import FloatArray, Mesh

__all__ = ["FORMATS", "promised", "written_and_promised"]

FORMATS = ("off", "obj", "ply", "stl", "glb", "gltf", "3mf")
# Words of the remarks by which `embed` takes a part of the promise back.
_NO_DIGITS, _NO_DECIMALS, _NO_FLOATS = "six significant digits", "more than six decimals", "double precision"


def written_and_promised(
    marked: Embedding, origin: Path, tolerance: str, folder: Path
) -> Iterator[tuple[str, Mesh]]:
    """Yield the model as its own format writes it into a folder, and that after each operation that is promised."""
    name = origin.name.removesuffix(".xz")
    (folder / "marked").mkdir()
    write_mesh(marked.mesh, folder / "marked" / name)
    mesh = read_mesh(folder / "marked" / name)
    yield "written", mesh
    rng = np.random.default_rng(crc32(name.encode()))
    yield from promised(Mesh(mesh.vertices, mesh.faces), tolerance, " ".join(marked.remarks), rng, folder)


def promised(
    mesh: Mesh, tolerance: str, remarks: str, rng: np.random.Generator, folder: Path
) -> Iterator[tuple[str, Mesh]]:
    """Yield a model after each operation, less those that the remarks of its embedding take back."""
    yield "shuffle", ATTACKS["shuffle"](mesh, 1, rng)
    yield "weld", ATTACKS["weld"](mesh, 1, rng)
    yield "unweld", ATTACKS["unweld"](mesh, 1, rng)
    yield "turned", ATTACKS["similarity"](mesh, 1, rng)
    if _NO_FLOATS not in remarks:
        yield "float32", ATTACKS["float32"](mesh, 1, rng)
        for _ in range(3):
            turned = ATTACKS["similarity"](mesh, 1, rng)
            yield "turned-float32", ATTACKS["float32"](ATTACKS["shuffle"](turned, 1, rng), 1, rng)
    for kind in FORMATS:
        if kind in ("stl", "glb", "gltf") and _NO_FLOATS in remarks:  # they hold no more
            continue
        path = folder / f"model.{kind}"
        write_mesh(mesh, path)
        yield f"to-{kind}", read_mesh(path)
    if not any(word in remarks for word in (_NO_DECIMALS, _NO_FLOATS)):
        yield "six-decimals", _printed(mesh, "%.6f")
        if tolerance != "strict" and _NO_DIGITS not in remarks:
            yield "six-digits", _printed(mesh, "%.6g")
    if tolerance == "tolerant":
        box, side = np.ptp(mesh.vertices, axis=0), np.ptp(mesh.vertices, axis=0).max()
        yield "grid-16", _on_grid(mesh, box, 2**16 - 1)
        yield "grid-16-cells", ATTACKS["quantisation"](mesh, 16, rng)
        yield "grid-16-side", _on_grid(mesh, np.full(3, side), 2**16 - 1)


def _printed(mesh: Mesh, how: str) -> Mesh:
    return Mesh(np.char.mod(how, mesh.vertices).astype(np.float64), mesh.faces)


def _on_grid(mesh: Mesh, size: FloatArray, steps: int) -> Mesh:
    low, step = mesh.vertices.min(axis=0), np.where(size > 0.0, size, 1.0) / steps
    return Mesh(low + np.rint((mesh.vertices - low) / step) * step, mesh.faces)
