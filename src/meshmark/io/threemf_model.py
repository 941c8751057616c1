"""One model part of a 3MF package: its objects, components and build items (3MF core specification 1.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.placement import Affine
from meshmark.io.threemf_mesh import attribute_spans, number, plain_lists, whole_number
from meshmark.io.xml_text import walk_xml
from meshmark.mesh import FloatArray, IntArray

__all__ = ["MeshText", "ModelPart", "Use", "open_model"]

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02 "
_PATH = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06 path"
_MILLIMETRES = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}


@dataclass(frozen=True, eq=False)
class MeshText:
    """The mesh of an object.

    vertices: (k, 3) as written; starts, ends: (k, 3) where in the part's text; faces: (m, 3).
    """

    vertices: FloatArray
    starts: IntArray
    ends: IntArray
    faces: IntArray


@dataclass(frozen=True, eq=False)
class Use:
    """An object put somewhere, by a build item or as a component; path names another part, or is None."""

    object_id: str
    path: str | None
    affine: Affine


@dataclass
class ModelPart:
    """What a part says. scale: millimetres per unit; found: names of elements outside the core."""

    name: str
    text: bytes
    scale: float = 1.0
    unit: str = "millimeter"
    meshes: dict[str, MeshText] = field(default_factory=dict)
    components: dict[str, list[Use]] = field(default_factory=dict)
    items: list[Use] = field(default_factory=list)
    found: set[str] = field(default_factory=set)


@dataclass
class _Rows:
    """Rows of three numbers under collection, and the spans of each."""

    values: list[list[float]] = field(default_factory=list)
    tags: list[int] = field(default_factory=list)


class _Reader:
    """Takes the parser's events; `stack` holds the tags that are open."""

    def __init__(self, name: str, text: bytes, quick: bool) -> None:
        self.part = ModelPart(name, text)
        self.left, self.lists = plain_lists(text) if quick else (text, {})
        self.stack: list[str] = []
        self.object_id = ""
        self.rows: dict[str, tuple[FloatArray, IntArray, IntArray]] = {}
        self.open = _Rows()

    def start(self, tag: str, attributes: Mapping[str, str], offset: int) -> None:
        parent, where = self.stack[-1] if self.stack else "", f"{self.part.name}, object {self.object_id}"
        tag = tag.removeprefix(_CORE)
        self.stack.append(tag)
        if (parent, tag) == ("vertices", "vertex"):
            self.open.values.append([number(attributes, name, where) for name in "xyz"])
            self.open.tags.append(offset)
        elif (parent, tag) == ("triangles", "triangle"):
            self.open.values.append([whole_number(attributes, name, where) for name in ("v1", "v2", "v3")])
        elif parent == "mesh" and tag in ("vertices", "triangles"):
            if tag in self.rows:
                raise FormatError(f"{where} has two lists of {tag}")
            self.open = _Rows()
            self._take_plain(tag, offset)
        elif parent == "":
            self._model(tag, attributes)
        else:
            self._structure(parent, tag, attributes)

    def end(self, _: str) -> None:
        tag = self.stack.pop()
        parent = self.stack[-1] if self.stack else ""
        if parent == "mesh" and tag in ("vertices", "triangles") and tag not in self.rows:
            self.rows[tag] = self._collected()
        elif (parent, tag) == ("object", "mesh"):
            self.part.meshes[self.object_id] = self._mesh()

    def _model(self, tag: str, attributes: Mapping[str, str]) -> None:
        if tag != "model":
            raise FormatError(f"{self.part.name} is not a 3MF model: its root element is {tag[-60:]!r}")
        self.part.unit = attributes.get("unit", "millimeter")
        if self.part.unit not in _MILLIMETRES:
            raise FormatError(
                f"{self.part.name} has unit {self.part.unit!r}, expected one of {', '.join(_MILLIMETRES)}"
            )
        self.part.scale = _MILLIMETRES[self.part.unit]

    def _structure(self, parent: str, tag: str, attributes: Mapping[str, str]) -> None:
        if (parent, tag) == ("resources", "object"):
            self.object_id = attributes.get("id", "").strip()
            if not self.object_id or self.object_id in self.part.components:
                raise FormatError(f"{self.part.name} has an object without an id of its own")
            self.part.components[self.object_id] = []
        elif (parent, tag) == ("object", "mesh"):
            if self.object_id in self.part.meshes:
                raise FormatError(f"{self.part.name}, object {self.object_id} has two meshes")
            self.rows = {}
        elif (parent, tag) == ("components", "component"):
            self.part.components[self.object_id].append(self._use(attributes))
        elif (parent, tag) == ("build", "item"):
            self.part.items.append(self._use(attributes))
        elif tag not in ("resources", "build", "components"):
            self.part.found.add(tag.rsplit(" ", 1)[-1])

    def _use(self, attributes: Mapping[str, str]) -> Use:
        words = attributes.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0").split()
        table = dict(zip("abcdefghijkl", words, strict=False))
        if len(words) != 12:
            raise FormatError(f"{self.part.name}: a transform has {len(words)} numbers, expected 12")
        numbers = [number(table, key, f"{self.part.name}, transform") for key in table]
        # 3MF multiplies a row vector from the left: the rows of the file are the columns here.
        rows = np.array(numbers).reshape(4, 3)
        path = attributes.get(_PATH)
        return Use(attributes.get("objectid", "").strip(), path, Affine(rows[:3].T.copy(), rows[3]))

    def _take_plain(self, tag: str, offset: int) -> None:
        if (plain := self.lists.get(offset)) is not None:
            self.rows[tag] = (plain.values, plain.starts, plain.ends)

    def _collected(self) -> tuple[FloatArray, IntArray, IntArray]:
        values = np.array(self.open.values, dtype=np.float64).reshape(-1, 3)
        names = (b"x", b"y", b"z")
        spans = [attribute_spans(self.part.text, at, names) for at in self.open.tags]
        both = np.array(spans, dtype=np.int64).reshape(-1, 3, 2)
        return values, both[..., 0], both[..., 1]

    def _mesh(self) -> MeshText:
        where = f"{self.part.name}, object {self.object_id}"
        if "vertices" not in self.rows:
            raise FormatError(f"{where} has a mesh without vertices")
        vertices, starts, ends = self.rows["vertices"]
        corners = self.rows["triangles"][0] if "triangles" in self.rows else np.empty((0, 3))
        if not np.isfinite(vertices).all():
            row = int(np.argmin(np.isfinite(vertices).all(axis=1)))
            raise FormatError(f"{where}: vertex {row} has a coordinate that is not finite")
        if corners.size and corners.max() >= len(vertices):
            row = int(np.argmax(corners.max(axis=1) >= len(vertices)))
            raise FormatError(
                f"{where}: triangle {row} has a vertex index out of range, expected 0 to {len(vertices) - 1}"
            )
        return MeshText(vertices, starts, ends, corners.astype(np.int64))


def open_model(name: str, text: bytes, quick: bool = True) -> ModelPart:
    """Read a model part. quick: take plainly written lists the fast way. Raises `FormatError`."""
    reader = _Reader(name, text, quick)
    walk_xml(reader.left, name, reader.start, reader.end)
    return reader.part
