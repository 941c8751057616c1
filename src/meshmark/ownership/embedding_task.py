"""What is to be marked, and how far it may be moved and seen: what every way of embedding is given."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, PRESENCE, bits_of
from meshmark.coding.polar import Bits
from meshmark.geometry.plane_patches import PlanePatches
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import VisibleChange
from meshmark.io.file_precision import conform
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.fingerprint.parameters import LEAST_POINTS
from meshmark.ownership.ownership_mark import OwnershipMark
from meshmark.ownership.points.parameters import MOST_POINTS
from meshmark.ownership.vertex_displacement import diagonal_of
from meshmark.strengths import VISIBLE_SHARES

__all__ = ["EmbeddingTask", "Owned"]

# A model of which this share is plane should stay plane: its patches off their planes by at most this, RMS over the
# diagonal.
PLANE_SHARE = 0.1
PLANE_OFF = 5e-5


@dataclass(frozen=True, eq=False, kw_only=True)
class Owned:
    """A mesh with a mark of the ownership layer.

    folded: share of the surface, 0 to 1, in cells where faces point in too many directions; 0 of a mark at points.
    held: (p,) points of its surface that carry the id of a part; None where no part has its own.
    """

    mesh: Mesh
    mark: OwnershipMark
    folded: float = 0.0
    held: NDArray[np.bool_] | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class EmbeddingTask:
    """An id to be put into a mesh.

    identity: of 64 or 32 bits, or `PRESENCE`, as `coding.message` counts them.
    strength: "subtle", "standard" or "strong"; rms: displacement at most, over the diagonal.
    """

    mesh: Mesh
    key: Key
    identity: int
    strength: str
    rms: float

    @cached_property
    def surface(self) -> Surface:
        """The welded surface."""
        return surface_of(self.mesh)

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the box around the vertices that faces use, scene units."""
        return diagonal_of(self.mesh)

    @property
    def budget(self) -> float:
        """RMS displacement at most, scene units."""
        return self.rms * self.diagonal

    @cached_property
    def label(self) -> Label:
        """Of the lattices that the mark lies in."""
        return Label.of_shape(self.surface.invariants, self.key)

    @property
    def bits(self) -> int:
        """How many bits the id has: 64 or 32; 0: there is none."""
        return bits_of(self.identity)

    @cached_property
    def word(self) -> Bits:
        """The code word of the id."""
        return Codec(self.key).encode(self.identity)

    @property
    def may_have_fingerprint(self) -> bool:
        """Whether the model has points enough for a fingerprint, and not too many, and an id of 64 bits."""
        return self.bits == ID_BITS and LEAST_POINTS <= len(self.surface.points) <= MOST_POINTS

    @cached_property
    def typical_word(self) -> Bits:
        """The word by which steps are judged.

        Where copies have a fingerprint, by which they are told when they are combined, it is one of the key, so
        that all have one step; else that of the id, which bears a little more noise then.
        """
        return Codec(self.key).encode(PRESENCE) if self.may_have_fingerprint else self.word

    @cached_property
    def planes(self) -> PlanePatches:
        """The plane parts of the surface."""
        return PlanePatches.of(self.surface.points, self.surface.faces)

    @property
    def has_planes(self) -> bool:
        """Whether so much of the surface is plane that it should stay so."""
        return self.planes.share >= PLANE_SHARE

    def keeps_planes(self, marked: Mesh) -> bool:
        """Return whether the plane parts of a marked mesh are as plane as they should be, if there are such."""
        if not self.has_planes:
            return True
        points = marked.vertices[self.surface.vertex_of_point]
        return self.planes.off_plane(points) <= PLANE_OFF * self.diagonal

    @property
    def seen(self) -> VisibleChange:
        """What judges how visible a mark is."""
        return self.surface.visible_change

    @property
    def share(self) -> float:
        """Share of the surface where the mark may be visible."""
        return VISIBLE_SHARES[self.strength]

    def moved(self, points: FloatArray) -> Mesh:
        """Return the mesh with the points of its surface (p, 3) elsewhere, as its file would hold it."""
        surface = self.surface
        moved = (points != surface.points).any(axis=1)[surface.point_of_vertex]
        vertices = np.where(moved[:, None], points[surface.point_of_vertex], self.mesh.vertices)
        return self.mesh.with_vertices(conform(self.mesh, vertices))
