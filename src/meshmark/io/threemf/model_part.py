"""One model part of a 3MF package: its objects, components and build items (3MF core specification 1.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.placement import Affine
from meshmark.io.text.numbers import line_number
from meshmark.io.threemf.number_lists import attribute_spans, number, plain_lists, whole_number
from meshmark.io.threemf.xml_text import as_utf8, walk_xml
from meshmark.mesh import FloatArray, IntArray

__all__ = ["MeshText", "ModelPart", "Use", "open_model"]

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02 "
_PATH = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06 path"
_OBJECT = ("model", "resources", "object")
_MESH = (*_OBJECT, "mesh")
_VERTEX, _TRIANGLE = (*_MESH, "vertices", "vertex"), (*_MESH, "triangles", "triangle")
_COMPONENT, _ITEM = (*_OBJECT, "components", "component"), ("model", "build", "item")
_DEEPEST = 100
_MILLIMETRES = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshText:
    """The mesh of an object.

    vertices: (k, 3) as written; starts, ends: (k, 3) where in the part's text; faces: (m, 3).
    """

    vertices: FloatArray
    starts: IntArray
    ends: IntArray
    faces: IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Use:
    """An object put somewhere, by a build item or as a component; path names another part, or is None."""

    object_id: str
    path: str | None
    affine: Affine


@dataclass(kw_only=True)
class ModelPart:
    """What a part says.

    text: in UTF-8; encoding: the file's. scale: millimetres per unit; found: names of elements outside the core.
    """

    name: str
    text: bytes
    encoding: str = "utf-8"
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
    """Takes the parser's events; `path` holds the tags that are open, the root first."""

    def __init__(self, name: str, content: bytes, quick: bool) -> None:
        text, encoding = as_utf8(content, name)
        self.part = ModelPart(name=name, text=text, encoding=encoding)
        self.left, self.lists, self.cuts = plain_lists(text) if quick else (text, {}, [])
        self.path: tuple[str, ...] = ()
        self.object_id = ""
        self.rows: dict[str, tuple[FloatArray, IntArray, IntArray]] = {}
        self.open = _Rows()

    def start(self, tag: str, attributes: Mapping[str, str], offset: int) -> None:
        where, above = f"{self.part.name}, object {self.object_id}", self.path
        tag = tag.removeprefix(_CORE)
        self.path = (*above, tag)
        if len(above) > _DEEPEST:
            raise FormatError(f"{self.part.name} nests its elements more than {_DEEPEST} deep")
        if self.path == _VERTEX:
            self.open.values.append([number(attributes, name, where) for name in "xyz"])
            self.open.tags.append(offset)
        elif self.path == _TRIANGLE:
            self.open.values.append([whole_number(attributes, name, where) for name in ("v1", "v2", "v3")])
        elif self.path in (_VERTEX[:-1], _TRIANGLE[:-1]):
            if tag in self.rows:
                raise FormatError(f"{where} has two lists of {tag}")
            self.open = _Rows()
            self._take_plain(tag, offset)
        elif not above:
            self._model(tag, attributes)
        else:
            self._structure(attributes)

    def end(self, _: str) -> None:
        if self.path in (_VERTEX[:-1], _TRIANGLE[:-1]) and self.path[-1] not in self.rows:
            self.rows[self.path[-1]] = self._collected()
        elif self.path == _MESH:
            self.part.meshes[self.object_id] = self._mesh()
        self.path = self.path[:-1]

    def line(self, offset: int) -> int:
        """Return the line of the part's text on which byte `offset` of what is left of it stands."""
        cut = sum(size for place, size in self.cuts if place <= offset)
        return line_number(np.frombuffer(self.part.text, np.uint8), offset + cut)

    def _model(self, tag: str, attributes: Mapping[str, str]) -> None:
        if tag != "model":
            raise FormatError(f"{self.part.name} is not a 3MF model: its root element is {tag[-60:]!r}")
        self.part.unit = attributes.get("unit", "millimeter")
        if self.part.unit not in _MILLIMETRES:
            raise FormatError(
                f"{self.part.name} has unit {self.part.unit!r}, expected one of {', '.join(_MILLIMETRES)}"
            )
        self.part.scale = _MILLIMETRES[self.part.unit]

    def _structure(self, attributes: Mapping[str, str]) -> None:
        if self.path == _OBJECT:
            self.object_id = attributes.get("id", "").strip()
            if not self.object_id or self.object_id in self.part.components:
                raise FormatError(f"{self.part.name} has an object without an id of its own")
            self.part.components[self.object_id] = []
        elif self.path == _MESH:
            if self.object_id in self.part.meshes:
                raise FormatError(f"{self.part.name}, object {self.object_id} has two meshes")
            self.rows = {}
        elif self.path == _COMPONENT:
            self.part.components[self.object_id].append(self._use(attributes))
        elif self.path == _ITEM:
            self.part.items.append(self._use(attributes))
        else:
            self.part.found.add(self.path[-1].rsplit(" ", 1)[-1])

    def _use(self, attributes: Mapping[str, str]) -> Use:
        words = attributes.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0").split()
        table = dict(zip("abcdefghijkl", words, strict=False))
        if len(words) != 12:
            raise FormatError(f"{self.part.name}: a transform has {len(words)} numbers, expected 12")
        numbers = [number(table, key, f"{self.part.name}, transform") for key in table]
        # 3MF multiplies a row vector from the left: the rows of the file are the columns here.
        rows = np.array(numbers).reshape(4, 3)
        path = attributes.get(_PATH)
        return Use(
            object_id=attributes.get("objectid", "").strip(),
            path=path,
            affine=Affine(rows[:3].T.copy(), rows[3]),
        )

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
        return MeshText(vertices=vertices, starts=starts, ends=ends, faces=corners.astype(np.int64))


def open_model(name: str, content: bytes, quick: bool = True) -> ModelPart:
    """Read a model part. quick: take plainly written lists the fast way. Raises `FormatError`."""
    reader = _Reader(name, content, quick)
    walk_xml(reader.left, name, reader.start, reader.end, reader.line)
    return reader.part
