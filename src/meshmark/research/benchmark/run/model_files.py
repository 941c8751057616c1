"""The models of a benchmark: files below a folder, their size classes and splits, and how a few are chosen."""

from __future__ import annotations

import lzma
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from io import BytesIO
from itertools import count
from pathlib import Path

from meshmark.data import hare_ply
from meshmark.errors import InputError
from meshmark.io import FORMATS, read_mesh, read_mesh_from, write_mesh
from meshmark.mesh import Mesh
from meshmark.research.benchmark.run.sample_shape import lopsided

__all__ = [
    "SIZE_CLASSES",
    "choose",
    "find_models",
    "load",
    "load_shipped",
    "size_class",
    "split_of",
    "spread",
    "write_shipped",
]

# Fewest different points of each class, and its name.
SIZE_CLASSES = (
    (0, "< 500"),
    (500, "500-2,500"),
    (2500, "2,500-5,000"),
    (5000, "5,000-20,000"),
    (20001, "> 20,000"),
)
_SPLITS = ("train", "test")
_PACKINGS = ("", ".gz", ".xz")
# A compressed file may not unpack to more than this.
_LARGEST_BYTES = 4 << 30


def find_models(folder: Path) -> list[str]:
    """Return the model files anywhere below a folder: paths relative to it, forward slashes, sorted.

    Every extension of `FORMATS` counts, also followed by .gz or .xz. Files and folders whose name starts with a dot
    are left out. Raises `InputError` where there is no such folder, or no model in it.
    """
    if not folder.is_dir():
        raise InputError(f"{folder} is not a folder, expected one with models")
    endings = tuple(
        name + packing for entry in FORMATS.values() for name in entry.extensions for packing in _PACKINGS
    )
    found = []
    for home, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        models = (name for name in files if name.lower().endswith(endings) and not name.startswith("."))
        found += [(Path(home) / name).relative_to(folder).as_posix() for name in models]
    if not found:
        known = " ".join(entry.extensions[0] for entry in FORMATS.values())
        raise InputError(
            f"there is no model below {folder}, expected files ending in {known}, also .gz or .xz"
        )
    return sorted(found)


def choose(folder: Path, models: Sequence[str], limit: int | None) -> list[str]:
    """Return `limit` of the models, spread over sizes: sorted by file size, the middle one, then the quarters, ...

    A larger limit only adds models (the order is van der Corput's sequence). The result is sorted by name.
    """
    if limit is not None and limit < 1:
        raise InputError(f"the limit is {limit}, expected at least 1 model")
    return sorted(spread(folder, models)[:limit])


def spread(folder: Path, models: Sequence[str]) -> list[str]:
    """Return all models in such an order that any first few are spread over sizes; see `choose`."""
    by_size = sorted(models, key=lambda model: ((folder / model).stat().st_size, model))
    chosen: dict[str, None] = {}
    for place in _halves():
        if len(chosen) == len(by_size):
            break
        chosen[by_size[int(place * len(by_size))]] = None
    return list(chosen)


def _halves() -> Iterator[float]:
    """Yield 1/2, 1/4, 3/4, 1/8, 5/8, 3/8, 7/8, ..."""
    for number in count(1):
        digits = f"{number:b}"
        yield int(digits[::-1], 2) / (1 << len(digits))


def load(path: Path) -> Mesh:
    """Read a model, also one packed with xz; raises what `read_mesh` raises, `InputError` for a damaged packing."""
    if path.suffix.lower() != ".xz":
        return read_mesh(path)
    with tempfile.TemporaryDirectory(prefix="meshmark-") as folder:
        plain = Path(folder) / path.stem
        try:
            with lzma.open(path) as packed, plain.open("wb") as target:
                shutil.copyfileobj(_Limited(packed, path), target)
        except (lzma.LZMAError, EOFError, OSError) as error:
            raise InputError(f"cannot unpack {path}: {error}") from None
        return read_mesh(plain)


class _Limited:
    """Reads from a stream, up to a limit."""

    def __init__(self, stream: lzma.LZMAFile, path: Path) -> None:
        self.stream, self.path, self.left = stream, path, _LARGEST_BYTES

    def read(self, size: int = -1) -> bytes:
        data = self.stream.read(size)
        self.left -= len(data)
        if self.left < 0:
            raise InputError(f"{self.path} unpacks to more than {_LARGEST_BYTES >> 30} GiB")
        return data


def size_class(points: int) -> str:
    """Return the name of the size class of a model with this number of different points."""
    return [name for least, name in SIZE_CLASSES if points >= least][-1]


def split_of(model: str) -> str:
    """Return "train" or "test" where a folder on the model's path is called that, else ""."""
    folders = model.split("/")[:-1]
    return next((name for name in folders if name in _SPLITS), "")


def load_shipped() -> Mesh:
    """Return the model that comes with the package."""
    return read_mesh_from(BytesIO(hare_ply()), "ply", "hare.ply")


def write_shipped(folder: Path) -> None:
    """Write the models that need no download into a folder: the package's own and two shapes made by formula."""
    folder.mkdir(parents=True, exist_ok=True)
    made = {"hare.ply": load_shipped(), "pebble.off": lopsided(140), "small-pebble.obj": lopsided(76)}
    for name, mesh in made.items():
        target = folder / name
        if not target.exists():
            write_mesh(mesh, target)
