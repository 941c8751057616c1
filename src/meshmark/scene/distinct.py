"""One showing of every stored mesh: the surface that is marked where a file shows a mesh several times.

glTF nodes and 3MF build items show one mesh in several places. A document with such copies tells for each vertex of
the scene which stored position it shows, and by which map (`placement.py`). What one copy is changed by, all are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from meshmark.document import Attributes, Deviation, Document
from meshmark.geometry.affine import Affine
from meshmark.geometry.surface import Surface
from meshmark.io.file_precision import conform
from meshmark.mesh import FloatArray, IntArray, Mesh

if TYPE_CHECKING:
    from meshmark.io.placement import Placement

__all__ = ["Distinct", "Piece", "as_shown", "distinct", "scene_of"]

# A vertex is the image of another one where it lies this near its place, over the largest coordinate.
_SAME = 1e-9


@runtime_checkable
class _Placed(Protocol):
    """A document that says where it shows what is stored."""

    @property
    def placements(self) -> tuple[Placement, ...]: ...


@dataclass(frozen=True, eq=False, kw_only=True)
class Distinct:
    """A scene of which each stored mesh is taken once.

    scene: the n vertices of the file; mesh: one showing of each, k vertices; a document of its own says what the
    file can hold of it. rows: (k,) the scene's vertices that `mesh` has. row: (n,) the vertex of `mesh` that each
    vertex of the scene is an image of. showing: (n,) the number of the placement of each. maps: by the showing of
    an image and that of the vertex in `mesh`, the map of the vertex to its image.
    """

    scene: Mesh
    mesh: Mesh
    rows: IntArray
    row: IntArray
    showing: IntArray
    maps: Mapping[tuple[int, int], Affine]

    def spread(self, vertices: FloatArray) -> FloatArray:
        """Return the scene's positions (n, 3) for positions (k, 3) of `mesh`; images of what stays do not move."""
        shift = (vertices - self.scene.vertices[self.rows])[self.row]
        moved = (shift != 0).any(axis=1)
        result = self.scene.vertices.copy()
        result[self.rows] = vertices
        own = np.zeros(len(self.row), bool)
        own[self.rows] = True
        for chosen, affine in self._groups(moved & ~own):
            result[chosen] += Affine(affine.linear, np.zeros(3))(shift[chosen])
        return result

    def whole(self, vertices: FloatArray) -> Mesh:
        """Return the scene as its file holds it, for positions (k, 3) of `mesh`."""
        return self.scene.with_vertices(conform(self.scene, self.spread(vertices)))

    def images(self) -> FloatArray:
        """Return the positions (n, 3) that all vertices have as images of those of `mesh`."""
        result = self.scene.vertices[self.rows][self.row]
        for chosen, affine in self._groups(np.ones(len(self.row), bool)):
            result[chosen] = affine(result[chosen])
        return result

    @cached_property
    def smallest(self) -> float:
        """The smallest stretch of any image against the vertices in `mesh`, 1 at most."""
        stretches = [np.linalg.svd(affine.linear, compute_uv=False)[2] for affine in self.maps.values()]
        return float(min(1.0, *stretches))

    def shown(self, surface: Surface) -> IntArray:
        """Return how many times the scene shows each point (p,) of the surface of `mesh`."""
        count, point = len(surface.points), surface.point_of_vertex[self.row]
        pairs = np.unique(self.showing * count + point)
        return np.bincount(pairs % count, minlength=count)

    def repeated(self, mesh: Mesh) -> Piece | None:
        """Return the part of `mesh`, marked or not, that is shown more than once, None where that is all of it."""
        pairs = np.unique(self.showing * len(self.rows) + self.row)
        times = np.bincount(pairs % len(self.rows), minlength=len(self.rows))
        faces = mesh.faces[(times > 1)[mesh.faces].all(axis=1)]
        return None if len(faces) in (0, len(mesh.faces)) else Piece.of(mesh, faces)

    def _groups(self, chosen: NDArray[np.bool_]) -> list[tuple[IntArray, Affine]]:
        """Return the chosen (n,) vertices that share a map, and the map."""
        count = int(self.showing.max()) + 1
        pair = self.showing * count + self.showing[self.rows][self.row]
        where = np.flatnonzero(chosen)
        order = where[np.argsort(pair[where], kind="stable")]
        values, starts = np.unique(pair[order], return_index=True)
        parts = np.split(order, starts[1:]) if len(values) else []
        pairs = [divmod(int(value), count) for value in values]
        return [(part, self.maps[ends]) for part, ends in zip(parts, pairs, strict=True)]


@dataclass(frozen=True, eq=False, kw_only=True)
class Piece:
    """Some faces of a mesh. rows: (k,) the vertices of `whole` that `mesh` has."""

    whole: Mesh
    mesh: Mesh
    rows: IntArray

    @classmethod
    def of(cls, whole: Mesh, faces: IntArray) -> Piece:
        """Return the piece with these faces (m, 3) of `whole`."""
        rows, corners = np.unique(faces, return_inverse=True)
        mesh = Mesh(whole.vertices[rows], corners.reshape(-1, 3))
        document = _OfPiece(whole=whole, rows=rows, vertices=mesh.vertices, faces=mesh.faces)
        return cls(whole=whole, mesh=Mesh(mesh.vertices, mesh.faces, document), rows=rows)

    def back(self, vertices: FloatArray) -> Mesh:
        """Return the whole as its file holds it, for positions (k, 3) of the piece."""
        return self.whole.with_vertices(conform(self.whole, _put(self.whole, self.rows, vertices)))


def _put(whole: Mesh, rows: IntArray, vertices: FloatArray) -> FloatArray:
    result = whole.vertices.copy()
    result[rows] = vertices
    return result


class _Inner:
    """What the documents of parts of a scene have in common: what it is they say of its file."""

    @property
    def _scene(self) -> Mesh:
        raise NotImplementedError

    @property
    def remarks(self) -> tuple[str, ...]:
        return self._base.remarks

    @property
    def format(self) -> str:
        return self._base.format

    def summary(self) -> dict[str, Any]:
        return self._base.summary()

    def deviations(self) -> tuple[Deviation, ...]:
        return self._base.deviations()

    def looks(self) -> tuple[str, ...] | None:
        return self._base.looks()

    def side_files(self) -> tuple[Path, ...]:
        return self._base.side_files()

    def attributes(self) -> Attributes:
        return Attributes()

    @property
    def _base(self) -> Document:
        return cast(Document, self._scene.document)  # only a scene with one has parts


@dataclass(frozen=True, eq=False, kw_only=True)
class _OfPiece(_Inner):
    """The document of `Piece.mesh`; see `Document`."""

    whole: Mesh
    rows: IntArray
    vertices: FloatArray
    faces: IntArray

    @property
    def _scene(self) -> Mesh:
        return self.whole

    def conform(self, vertices: FloatArray) -> FloatArray:
        return conform(self.whole, _put(self.whole, self.rows, vertices))[self.rows]

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        return self._base.patched(_put(self.whole, self.rows, vertices), name)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Once(_Inner):
    """The document of `Distinct.mesh`: that of the scene, through its eyes; see `Document`."""

    distinct: Distinct
    vertices: FloatArray
    faces: IntArray

    @property
    def _scene(self) -> Mesh:
        return self.distinct.scene

    def conform(self, vertices: FloatArray) -> FloatArray:
        return conform(self.distinct.scene, self.distinct.spread(vertices))[self.distinct.rows]

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        return self._base.patched(self.distinct.spread(vertices), name)

    def attributes(self) -> Attributes:
        found = self._base.attributes()
        rows = self.distinct.rows
        return replace(
            found,
            normals=None if found.normals is None else found.normals[rows],
            texcoords=None if found.texcoords is None else found.texcoords[rows],
            colors=None if found.colors is None else found.colors[rows],
        )


def scene_of(mesh: Mesh) -> Distinct | None:
    """Return the scene that a mesh made by `distinct` was taken from, None for any other."""
    return mesh.document.distinct if isinstance(mesh.document, _Once) else None


def as_shown(mesh: Mesh) -> Mesh:
    """Return the whole scene for a mesh that stands for its copies, any other mesh itself."""
    found = scene_of(mesh)
    return mesh if found is None else found.whole(mesh.vertices)


def distinct(mesh: Mesh) -> Distinct | None:
    """Return the mesh with each stored position shown once; None where nothing is shown in two places.

    Nor where vertices are not the images that the document says they are: they were changed one by one. Of the
    showings of a mesh the first of the largest is taken, so that none of the others moves farther.
    """
    document = mesh.document
    if document is None:
        return None
    from meshmark.io.source import SourceFile
    from meshmark.scene.showings import faces_once, maps_between, placement_ranks

    inner = document.document if isinstance(document, SourceFile) else document
    if not isinstance(inner, _Placed) or len(inner.placements) < 2:
        return None
    placements = inner.placements
    slots = np.concatenate([item.slots for item in placements])
    if len(slots) == len(np.unique(slots)):
        return None
    showing = np.repeat(np.arange(len(placements)), [len(item.slots) for item in placements])
    rank = placement_ranks(slots, showing, placements)
    order = np.argsort(rank[showing], kind="stable")
    _, first, slot = np.unique(slots[order], return_index=True, return_inverse=True)
    source = np.empty(len(slots), np.int64)
    source[order] = order[first][slot]
    if (mesh.vertices == mesh.vertices[source]).all():
        return None
    rows, row = np.unique(source, return_inverse=True)
    faces = faces_once(row[mesh.faces], rank[showing[mesh.faces[:, 0]]])
    found = Distinct(
        scene=mesh,
        mesh=mesh,
        rows=rows,
        row=row,
        showing=showing,
        maps=maps_between(showing, source, placements),
    )
    if np.abs(found.images() - mesh.vertices).max() > _SAME * np.abs(mesh.vertices).max():
        return None
    once = Mesh(mesh.vertices[rows], faces)
    return replace(
        found,
        mesh=Mesh(once.vertices, once.faces, _Once(distinct=found, vertices=once.vertices, faces=once.faces)),
    )
