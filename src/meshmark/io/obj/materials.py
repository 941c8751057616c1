"""The material libraries that an OBJ file names, and the images that those name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath

from meshmark.io.obj.keyword_lines import Rows

__all__ = ["material_files"]

_IMAGE = re.compile(rb"[ \t]*(?:map_\w+|bump|disp|decal|refl|norm)[ \t]+(.+)", re.IGNORECASE)
# A material library is text of a few kilobytes; what is larger is none.
_MAX_LIBRARY = 16 << 20


def material_files(libraries: Rows, path: Path) -> tuple[Path, ...]:
    """Return the existing libraries that `mtllib` lines of an OBJ file at `path` name, and their images.

    Only files inside the model's folder count: a model must not make a save copy other files.
    """
    found: dict[Path, None] = {}
    for library in _named(libraries.texts(), path.parent):
        found[library] = None
        if library.stat().st_size <= _MAX_LIBRARY:
            try:
                content = library.read_bytes()
            except OSError:
                continue
            images = [line[1] for line in map(_IMAGE.match, content.splitlines()) if line]
            found |= dict.fromkeys(_named(images, library.parent))
    return tuple(origin for origin in found if origin != path)


def _named(lines: Iterable[bytes], folder: Path) -> Iterator[Path]:
    for line in lines:
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
