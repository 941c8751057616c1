"""What the triangles of an OBJ file are painted with: the colours and images of its material libraries."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path, PurePosixPath

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import members
from meshmark.errors import FormatError
from meshmark.io.colors import to_linear
from meshmark.io.image_magic import HEAD, is_image
from meshmark.io.inside import head_inside, read_inside
from meshmark.io.obj.keyword_lines import Rows, corner_indices, obj_lines
from meshmark.io.obj.materials import library_text, named_files
from meshmark.io.paint import Coat, Paint, painted_by
from meshmark.io.picture_file import pixels_of
from meshmark.io.polygons import fan_corners
from meshmark.io.text.numbers import parse_floats
from meshmark.mesh import IntArray

__all__ = ["obj_paint"]

_WORDS = re.compile(rb"^[ \t]*(newmtl|Kd|map_Kd)[ \t]+(.+?)[ \t\r]*$", re.MULTILINE | re.IGNORECASE)
_LONGEST = 1 << 28


@dataclass(frozen=True, eq=False, kw_only=True)
class _Material:
    factor: tuple[float, float, float] = (1.0, 1.0, 1.0)
    image: NDArray[np.uint8] | None = None


def obj_paint(data: bytes, path: Path) -> Paint | None:
    """Return the paint of the triangles of an OBJ file at `path`; None where no material says their colour.

    An image takes the place of the colour of its material (`Kd`), as programs write any colour beside an image.
    """
    if b"mtllib" not in data:
        return None
    lines = obj_lines(data, (b"v", b"vt", b"f", b"usemtl", b"mtllib"))
    materials = _materials(lines.rows[b"mtllib"], path.parent)
    polygons = lines.rows[b"f"]
    used = lines.rows[b"usemtl"]
    if not materials or not len(used):
        return None
    # The material of a polygon is that of the last line before it that names one; -1 before the first.
    last = np.searchsorted(used.numbers, polygons.numbers) - 1
    polygon = members(np.maximum(polygons.counts - 2, 0))[0]
    places = _places(polygons, lines.rows[b"vt"])[fan_corners(polygons.counts)]
    names = _names(used)
    coats = []
    for run in _runs(last[polygon]):
        line = int(last[polygon[run.start]])
        found = materials.get(names[line], _Material()) if line >= 0 else _Material()
        at = None if found.image is None else places[run]
        image = found.image if at is not None and np.isfinite(at).all() else None
        coats.append(Coat(count=run.stop - run.start, factor=found.factor, image=image, places=at))
    return painted_by([each if each.image is not None else _without_image(each) for each in coats])


def _without_image(coat: Coat) -> Coat:
    return Coat(count=coat.count, factor=coat.factor)


def _names(used: Rows) -> list[bytes]:
    """Return the name on each `usemtl` line, empty where there is none."""
    said = iter(used.texts())
    return [next(said) if count else b"" for count in used.counts]


def _runs(numbers: IntArray) -> list[slice]:
    """Return the runs of equal numbers."""
    turns = np.flatnonzero(np.diff(numbers)) + 1
    bounds = [0, *turns.tolist(), len(numbers)]
    return [slice(one, other) for one, other in pairwise(bounds) if other > one]


def _places(polygons: Rows, table: Rows) -> NDArray[np.float32]:
    """Return (k, 2) of all corners, from the upper left; NaN where a corner has none."""
    try:
        index = corner_indices(polygons, 1, table)
        starts, ends = table.columns(0, 2, "vt")
    except FormatError:
        return np.full((int(polygons.counts.sum()), 2), np.nan, np.float32)
    numbers = parse_floats(table.text, starts.ravel(), ends.ravel(), finite=False).reshape(-1, 2)
    places = np.concatenate([numbers * [1.0, -1.0] + [0.0, 1.0], [[np.nan, np.nan]]])
    return places[index].astype(np.float32)


def _materials(libraries: Rows, home: Path) -> dict[bytes, _Material]:
    """Return the materials of the libraries that exist, by name."""
    found: dict[bytes, _Material] = {}
    for name in named_files(libraries.texts()):
        content = library_text(home, name)
        if content is None:
            continue
        current = b""
        for word, value in _WORDS.findall(content):
            if word.lower() == b"newmtl":
                current = value
                found.setdefault(current, _Material())
            elif word.lower() == b"kd":
                found[current] = _with_colour(found.get(current, _Material()), value)
            else:
                image = _image(home, PurePosixPath(name).parent, value)
                if image is not None:
                    found[current] = _Material(image=image)
    return found


def _with_colour(material: _Material, value: bytes) -> _Material:
    """Return a material with the colour of a `Kd` line, unless it has an image."""
    try:
        given = np.array([float(word) for word in value.split()[:3]])
    except ValueError:
        return material
    if material.image is not None or len(given) != 3 or not np.isfinite(given).all():
        return material
    red, green, blue = to_linear(np.clip(given, 0.0, 1.0)).tolist()
    return _Material(factor=(red, green, blue))


def _image(home: Path, beside: PurePosixPath, value: bytes) -> NDArray[np.uint8] | None:
    """Return the first image that a `map_Kd` line may name and that is there."""
    for name in named_files([value]):
        place = str(beside / name)
        if is_image(head_inside(home, place, HEAD)):
            return pixels_of(read_inside(home, place, _LONGEST))
    return None
