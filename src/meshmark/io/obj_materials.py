"""The material libraries that an OBJ file names, and the images that those name."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

__all__ = ["material_files"]

_MTLLIB = re.compile(rb"(?:^|[\r\n])[ \t]*mtllib[ \t]+([^\r\n]+)")
_IMAGE = re.compile(
    rb"(?:^|[\r\n])[ \t]*(?:map_\w+|bump|disp|decal|refl|norm)[ \t]+([^\r\n]+)", re.IGNORECASE
)
# A material library is text of a few kilobytes; what is larger is none.
_MAX_LIBRARY = 16 << 20


def material_files(data: bytes, path: Path) -> tuple[Path, ...]:
    """Return the existing material libraries of an OBJ file at `path`, and the images they name.

    Only files inside the model's folder count: a model must not make a save copy other files.
    """
    found: dict[Path, None] = {}
    for library in _named(_MTLLIB, data, path.parent):
        found[library] = None
        if library.stat().st_size <= _MAX_LIBRARY:
            try:
                content = library.read_bytes()
            except OSError:
                continue
            found |= dict.fromkeys(_named(_IMAGE, content, library.parent))
    return tuple(origin for origin in found if origin != path)


def _named(pattern: re.Pattern[bytes], data: bytes, folder: Path) -> Iterator[Path]:
    for line in pattern.findall(data):
        words = line.decode("utf-8", "replace").split("#")[0].strip()
        # The name may have spaces, or options and other names before it.
        parts = words.split()
        for name in dict.fromkeys([words, *parts, *(" ".join(parts[k:]) for k in range(1, len(parts)))][:20]):
            if (place := _inside(folder, name)) is not None:
                yield place


def _inside(folder: Path, name: str) -> Path | None:
    pure = PurePosixPath(name.replace("\\", "/"))
    if pure.is_absolute() or ".." in pure.parts or ":" in name or "\0" in name:
        return None
    try:
        place = folder / pure
        inside = place.is_file() and place.resolve().is_relative_to(folder.resolve())
    except OSError:
        return None
    return place if inside else None
