"""The development models, read from ../shared/data."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.research.benchmark.run.model_files import SIZE_CLASSES, load
from meshmark.research.benchmark.run.model_files import size_class as size_class_of

__all__ = ["DATA", "SIZE_CLASSES", "load", "model_paths", "size_class"]

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


def model_paths(*folders: str) -> Iterator[Path]:
    """Yield the compressed models below these folders of the data, such as "models/test", in order."""
    for folder in folders:
        yield from sorted((DATA / folder).glob("*.xz"))


def size_class(mesh: Mesh) -> str:
    """Return the size class of a model by its number of different points."""
    return size_class_of(len(weld(mesh).points))
