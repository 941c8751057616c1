"""The development models in ../shared/data are compressed; tests unpack them to read them."""

from __future__ import annotations

import lzma
import tempfile
from pathlib import Path

from meshmark.io import read_mesh
from meshmark.mesh import Mesh


def read_packed(path: Path) -> Mesh:
    """Read a model file compressed as `.xz`."""
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / path.stem
        plain.write_bytes(lzma.decompress(path.read_bytes()))
        return read_mesh(plain)
