"""What one model is like: its counts, its size, and whether its surface is closed."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from meshmark.geometry.areas import face_areas
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.mesh import IntArray, Mesh
from meshmark.metrics.displacement import diagonal

__all__ = ["Shape", "describe"]


@dataclass(frozen=True, kw_only=True)
class Shape:
    """Facts about a model; coincident vertices count as one point.

    parts:           connected pieces of surface.
    open_edges:      edges that only one triangle uses: 0 for a closed surface.
    branching_edges: edges that more than two triangles use.
    size:            extent along x, y and z; `diagonal` is that of the bounding box; model units.
    area:            of all triangles, in squared model units.
    """

    vertices: int
    points: int
    faces: int
    parts: int
    open_edges: int
    branching_edges: int
    size: tuple[float, float, float]
    diagonal: float
    area: float

    @property
    def closed(self) -> bool:
        """Whether each edge joins exactly two triangles."""
        return self.faces > 0 and self.open_edges == 0 and self.branching_edges == 0

    def to_dict(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        return {**asdict(self), "size": list(self.size), "closed": self.closed}


def describe(mesh: Mesh) -> Shape:
    """Return the facts about a model; raises `InputError` for one without vertices or extent."""
    length = diagonal(mesh)
    welded = weld(mesh)
    uses = _edge_uses(welded)
    x, y, z = np.ptp(mesh.vertices, axis=0)
    return Shape(
        vertices=len(mesh.vertices),
        points=len(welded.points),
        faces=len(mesh.faces),
        parts=_count_parts(welded),
        open_edges=int((uses == 1).sum()),
        branching_edges=int((uses > 2).sum()),
        size=(float(x), float(y), float(z)),
        diagonal=length,
        area=float(face_areas(welded.points, welded.faces).sum()),
    )


def _edge_uses(welded: Surface) -> IntArray:
    """Return, for each edge, how many triangles use it."""
    ends = np.sort(welded.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    counts: IntArray = np.unique(ends[:, 0] * len(welded.points) + ends[:, 1], return_counts=True)[1]
    return counts


def _count_parts(welded: Surface) -> int:
    count, (a, b, c) = len(welded.points), welded.faces.T
    links = coo_array(
        (np.ones(2 * len(a), np.int8), (np.concatenate([a, b]), np.concatenate([b, c]))), shape=(count, count)
    )
    loose = count - len(np.unique(welded.faces))
    return int(connected_components(links, directed=False)[0]) - loose
