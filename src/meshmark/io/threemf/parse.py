"""3MF: a save patches the coordinates inside the model's XML; every other byte of the package stays.

The scene is what the build items show, in millimetres, with component transforms applied; an object used
twice appears twice. Objects that no build item shows, objects without triangles (beam lattices, slices) and
what a transform flattens stay untouched and are no part of the surface. Specification: 3MF core 1.3.0 with
the production extension's paths.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.document import Attributes, Deviation
from meshmark.errors import FormatError, InputError
from meshmark.io.placement import Affine, Placement, place, pull_back
from meshmark.io.text.number_printing import format_numbers, round_numbers
from meshmark.io.text.number_style import NumberStyle, detect_style, digits_needed
from meshmark.io.text.positions import splice
from meshmark.io.threemf.model_part import MeshText, ModelPart, Use, open_model
from meshmark.io.threemf.package import main_model, part_name, read_part
from meshmark.io.zip_package import Package, open_package
from meshmark.mesh import FloatArray, IntArray

__all__ = ["ThreeMfDocument", "parse_3mf"]

# A few bytes of components can show a large mesh very often: these bound what a small file may ask for.
_MOST_USES, _MOST_ROWS, _MOST_FACES = 100_000, 30_000_000, 60_000_000

Key = tuple[str, str]


@dataclass(frozen=True, eq=False, kw_only=True)
class ThreeMfDocument:
    """A 3MF package; the `Document` protocol says what its methods promise.

    stored: (s, 3) coordinates as written, of the objects shown; first: the row where each object starts.
    """

    package: Package
    parts: Mapping[str, ModelPart]
    stored: FloatArray
    first: Mapping[Key, int]
    placements: tuple[Placement, ...]
    vertices: FloatArray
    faces: IntArray
    format: str = "3mf"
    remarks: tuple[str, ...] = ()

    def conform(self, vertices: FloatArray) -> FloatArray:
        """Return the positions (n, 3) that reading the written file would give, to the last bit."""
        target, moved = self._pulled(vertices)
        rounded = target.copy()
        for name, rows in self._rows_of_parts().items():
            rounded[rows], _, _ = self._rounded(name, rows, target, moved)
        return place(rounded, self.placements)

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        """Return the package with the coordinates that moved rewritten in the file's own manner."""
        target, moved = self._pulled(vertices)
        contents = {}
        for part, rows in self._rows_of_parts().items():
            rounded, style, digits = self._rounded(part, rows, target, moved)
            starts, ends = self._spans(part)
            changed = np.flatnonzero(rounded.ravel() != self.stored[rows].ravel())
            order = changed[np.argsort(starts.ravel()[changed])]
            letters, lengths = format_numbers(style, digits, rounded.ravel()[order])
            text = self.parts[part].text
            if len(order):
                fresh = splice(text, starts.ravel()[order], ends.ravel()[order], letters, lengths)
                encoding = self.parts[part].encoding
                contents[part] = fresh if encoding == "utf-8" else fresh.decode().encode(encoding)
        return {name: self.package.with_parts(contents)}

    def deviations(self) -> tuple[Deviation, ...]:
        """Return none: what build items show is the surface."""
        return ()

    def looks(self) -> tuple[str, ...] | None:
        """Return None: materials are not read."""
        return None

    def attributes(self) -> Attributes:
        """Return what a conversion to another format may keep: no per-vertex data, only names."""
        found = {tag for part in self.parts.values() for tag in part.found}
        names = {
            "materials": found & {"basematerials", "colorgroup", "texture2dgroup", "compositematerials"},
            "metadata": found & {"metadata"},
            "separate objects": len(self.placements) > 1,
            "beam lattices": found & {"beamlattice"},
            "slices": found & {"slicestack"},
        }
        return Attributes(other=tuple(name for name, present in names.items() if present))

    def summary(self) -> dict[str, Any]:
        """Return what `meshmark info` prints."""
        main = next(iter(self.parts.values()))
        return {
            "encoding": "zipped XML",
            "precision": self._style(main.name).describe() if main.meshes else "text",
            "unit": main.unit,
            "parts": len(self.parts),
            "objects": sum(len(part.components) for part in self.parts.values()),
            "instances": len(self.placements),
            "members": len(self.package.archive.infolist()),
        }

    def side_files(self) -> tuple[Path, ...]:
        """Return nothing: a package holds all it needs."""
        return ()

    def _pulled(self, vertices: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        if np.shape(vertices) != self.vertices.shape or not np.isfinite(vertices).all():
            raise InputError(f"new positions must be finite and of shape {self.vertices.shape}")
        return pull_back(self.stored, self.placements, self.vertices, vertices)

    def _meshes(self, part: str) -> list[MeshText]:
        return [self.parts[part].meshes[key] for name, key in self.first if name == part]

    def _rows_of_parts(self) -> dict[str, IntArray]:
        rows: dict[str, list[IntArray]] = {}
        for (name, key), start in self.first.items():
            count = len(self.parts[name].meshes[key].vertices)
            rows.setdefault(name, []).append(np.arange(start, start + count))
        return {name: np.concatenate(blocks) for name, blocks in rows.items()}

    def _spans(self, part: str) -> tuple[IntArray, IntArray]:
        meshes = self._meshes(part)
        return np.concatenate([item.starts for item in meshes]), np.concatenate(
            [item.ends for item in meshes]
        )

    def _style(self, part: str) -> NumberStyle:
        starts, ends = (item.ravel() for item in self._spans(part))
        values = np.concatenate([item.vertices for item in self._meshes(part)]).ravel()
        order = np.argsort(starts)
        text = np.frombuffer(self.parts[part].text, np.uint8)
        return detect_style(text, starts[order], ends[order], values[order])

    def _rounded(
        self, part: str, rows: IntArray, target: FloatArray, moved: NDArray[np.bool_]
    ) -> tuple[FloatArray, NumberStyle, int]:
        """Return the rows of a part as they will read, and how they are written."""
        style = self._style(part)
        # Digits must resolve 1e-7 of the scene's diagonal after the largest magnification of any placement.
        largest = max(np.abs(item.affine.linear).max() for item in self.placements)
        digits = max(digits_needed(style, self.vertices / largest), digits_needed(style, self.stored))
        kept = (target[rows] == self.stored[rows]) | ~moved[rows, None]
        read = round_numbers(style, digits, target[rows].ravel()).reshape(-1, 3)
        if not np.isfinite(read).all():
            raise InputError("a new position is beyond the range of floating point numbers")
        return np.where(kept, self.stored[rows], read), style, digits


def parse_3mf(data: bytes, path: Path) -> ThreeMfDocument:
    """Read a 3MF package. Raises `FormatError`."""
    package = open_package(data)
    main = main_model(package)
    parts = {main: open_model(main, read_part(package, main))}
    first, stored = dict[Key, int](), list[FloatArray]()
    placements, faces = list[Placement](), list[IntArray]()
    rows = total = kept = 0
    for (name, key), affine in _showings(package, parts, main):
        mesh = parts[name].meshes[key]
        if (name, key) not in first:
            first[name, key] = kept
            stored.append(mesh.vertices)
            kept += len(mesh.vertices)
        start, count = first[name, key], len(mesh.vertices)
        faces.append(mesh.faces + rows)
        rows, total = rows + count, total + len(mesh.faces)
        if rows > _MOST_ROWS or total > _MOST_FACES:
            raise FormatError(f"the build shows more than {_MOST_ROWS:,} points or {_MOST_FACES:,} triangles")
        placements.append(Placement(np.arange(start, start + count), affine))
    if not placements:
        raise FormatError(f"{path.name} has no triangles in any build item")
    points = np.concatenate(stored)
    vertices, triangles = place(points, placements), np.concatenate(faces)
    if not np.isfinite(vertices).all():
        raise FormatError(f"{path.name}: its transforms take positions beyond any range")
    vertices.flags.writeable = triangles.flags.writeable = False
    return ThreeMfDocument(
        package=package,
        parts=parts,
        stored=points,
        first=first,
        placements=tuple(placements),
        vertices=vertices,
        faces=triangles,
    )


def _showings(package: Package, parts: dict[str, ModelPart], main: str) -> list[tuple[Key, Affine]]:
    """Return the meshes with triangles that the build items show, in order; opens further parts."""
    found = []
    maps = [Affine(np.eye(3) * parts[main].scale, np.zeros(3))]
    for name, use, above in _uses(package, parts, main):
        maps.append(maps[above].after(use.affine))
        if not (np.isfinite(maps[-1].linear).all() and np.isfinite(maps[-1].offset).all()):
            raise FormatError(f"{name}: a transform is beyond the range of floating point numbers")
        mesh = parts[name].meshes.get(use.object_id)
        if mesh is not None and len(mesh.faces) and maps[-1].is_usable:
            found.append(((name, use.object_id), maps[-1]))
    return found


def _uses(package: Package, parts: dict[str, ModelPart], main: str) -> list[tuple[str, Use, int]]:
    """Return all uses of objects, depth first: the part of the object, the use, and the number of the use above it.

    They are numbered from 1; 0 is the build itself. Their number is judged here, before any of them costs more.
    """
    stack = [(main, use, 0, 0) for use in reversed(parts[main].items)]
    found: list[tuple[str, Use, int]] = []
    while stack:
        home, use, above, depth = stack.pop()
        name = home if use.path is None else package.member(part_name(use.path)).filename
        part = parts.get(name) or parts.setdefault(name, open_model(name, read_part(package, name)))
        if use.object_id not in part.components:
            raise FormatError(f"{name} has no object {use.object_id!r}, which {home} refers to")
        found.append((name, use, above))
        if len(found) > _MOST_USES or depth > sum(len(item.components) for item in parts.values()):
            raise FormatError(f"{home}: its components contain themselves, or are more than {_MOST_USES:,}")
        below: list[Use] = part.components[use.object_id]
        stack += [(name, item, len(found), depth + 1) for item in reversed(below)]
    return found
