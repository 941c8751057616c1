"""The development models, read from ../shared/data."""

from __future__ import annotations

import lzma
import tempfile
from collections.abc import Iterator
from pathlib import Path

from meshmark.geometry.weld import weld
from meshmark.io import read_mesh
from meshmark.mesh import Mesh

__all__ = ["DATA", "SIZE_CLASSES", "load", "model_paths", "size_class"]

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
SIZE_CLASSES = (
    (0, "< 500"),
    (500, "500-2,500"),
    (2500, "2,500-5,000"),
    (5000, "5,000-20,000"),
    (20001, "> 20,000"),
)


def model_paths(*folders: str) -> Iterator[Path]:
    """Yield the compressed models below these folders of the data, such as "models/test", in order."""
    for folder in folders:
        yield from sorted((DATA / folder).glob("*.xz"))


def load(path: Path) -> Mesh:
    """Read a model, decompressing `.xz`; raises what `read_mesh` raises."""
    if path.suffix != ".xz":
        return read_mesh(path)
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / path.stem
        plain.write_bytes(lzma.decompress(path.read_bytes()))
        return read_mesh(plain)


def size_class(mesh: Mesh) -> str:
    """Return the size class of a model by its number of different points."""
    count = len(weld(mesh).points)
    return [name for least, name in SIZE_CLASSES if count >= least][-1]
