"""The material libraries that an OBJ file names, and the images that those name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath

from meshmark.io.image_magic import HEAD, is_image
from meshmark.io.inside import head_inside, read_inside
from meshmark.io.obj.keyword_lines import Rows

__all__ = ["library_text", "material_files", "named_files"]

_IMAGE = re.compile(rb"[ \t]*(?:map_\w+|bump|disp|decal|refl|norm)[ \t]+(.+)", re.IGNORECASE)
_MATERIAL = re.compile(rb"^[ \t]*newmtl\b", re.MULTILINE | re.IGNORECASE)
# A material library is text of a few kilobytes; what is larger is none.
_MAX_LIBRARY = 16 << 20


def material_files(libraries: Rows, path: Path) -> tuple[Path, ...]:
    """Return the existing libraries that `mtllib` lines of an OBJ file at `path` name, and their images.

    Only libraries that define a material, and images, inside the model's folder count: a model must not make a save
    copy other files.
    """
    found: dict[Path, None] = {}
    home = path.parent
    for name in named_files(libraries.texts()):
        content = library_text(home, name)
        if content is None:
            continue
        found[home / name] = None
        beside = PurePosixPath(name).parent
        images = [line[1] for line in map(_IMAGE.match, content.splitlines()) if line]
        for image in named_files(images):
            place = str(beside / image)
            if is_image(head_inside(home, place, HEAD)):
                found[home / place] = None
    return tuple(origin for origin in found if origin != path)


def library_text(home: Path, name: str) -> bytes | None:
    """Return the text of a material library, None for any other file."""
    try:
        content = read_inside(home, name, _MAX_LIBRARY)
    except (OSError, ValueError):
        return None
    return content if _MATERIAL.search(content) and b"\0" not in content else None


def named_files(lines: Iterable[bytes]) -> Iterator[str]:
    """Yield what may be the name of a file on each line, relative to the folder of the file with the lines."""
    for line in lines:
        words = line.decode("utf-8", "replace").split("#")[0].strip()
        # The name may have spaces, or options and other names before it.
        parts = words.split()
        names = [words, *parts, *(" ".join(parts[k:]) for k in range(1, len(parts)))]
        for name in dict.fromkeys(names[:20]):
            pure = PurePosixPath(name.replace("\\", "/"))
            if pure.parts and not (pure.is_absolute() or ".." in pure.parts or ":" in name or "\0" in name):
                yield str(pure)
