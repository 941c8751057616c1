"""The place of a local edit: the points nearest to one that the generator draws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from meshmark.attacks.attack import Attacked
from meshmark.errors import InputError
from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.areas import area_vectors, sum_at_points
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["Patch", "draw_patch", "unit"]

# The edit fades to nothing this much beyond the last point it touches, so that it provably moves that one, too.
MARGIN = 1.05


@dataclass(frozen=True, eq=False, kw_only=True)
class Patch:
    """Points of a welded mesh around a centre.

    members: (k,) points, nearest first, the centre leading; reach: (k,) their distance over `radius`, below 1.
    radius:  where the edit fades to nothing, in scene units. normal: (3,) unit, the mean over the patch.
    """

    mesh: Mesh
    welded: Surface
    members: IntArray
    reach: FloatArray
    radius: float
    normal: FloatArray

    @property
    def points(self) -> FloatArray:
        """(k, 3): where the members are."""
        return self.welded.points[self.members]

    @property
    def holds(self) -> NDArray[np.bool_]:
        """(p,): whether a point is a member."""
        inside = np.zeros(len(self.welded.points), bool)
        inside[self.members] = True
        return inside

    def moved_to(self, places: FloatArray) -> Attacked:
        """Return the mesh with its members at `places` (k, 3); vertices that coincide stay together."""
        points = self.welded.points.copy()
        points[self.members] = places
        touched = np.flatnonzero(self.holds[self.welded.point_of_vertex])
        vertices = self.mesh.vertices.copy()
        vertices[touched] = points[self.welded.point_of_vertex[touched]]
        altered = (vertices != self.mesh.vertices).any(axis=1)
        return Attacked(
            mesh=self.mesh.with_vertices(vertices), origin=np.arange(len(vertices)), altered=altered
        )


def draw_patch(mesh: Mesh, share: float, rng: np.random.Generator) -> Patch:
    """Draw a centre and take the `share` (0 to 1) of the points nearest to it, at least one.

    Near means along the edges; where the centre's part of the model has fewer points, straight. Points of no face
    do not count. Raises `InputError` for a share of 1 or more, and a mesh without faces.
    """
    if share >= 1.0:
        raise InputError(f"strength {share:g} is out of range, expected a share of the vertices below 1")
    welded = weld(mesh)
    used = np.unique(welded.faces)
    if not len(used):
        raise InputError("the model has no faces, expected a surface to edit")
    count = min(max(round(share * len(used)), 1), len(used) - 1)
    centre = int(rng.choice(used))
    distance = _distances(welded, centre, used, count)
    order = used[np.argsort(distance[used], kind="stable")]
    members, following = order[:count], order[count]
    radius = MARGIN * distance[members[-1]]
    if np.isfinite(distance[following]):
        radius = max(radius, distance[following])
    reach = distance[members] / radius
    return Patch(
        mesh=mesh,
        welded=welded,
        members=members,
        reach=reach,
        radius=radius,
        normal=_normal(welded, members, reach, rng),
    )


def unit(rng: np.random.Generator) -> FloatArray:
    """Return a random direction (3,)."""
    vector = rng.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def _distances(welded: Surface, centre: int, used: IntArray, count: int) -> FloatArray:
    points = welded.points
    size = float(np.ptp(points[used], axis=0).max())
    edges = unique_edges(welded.faces)
    lengths = np.linalg.norm((points[edges[:, 0]] - points[edges[:, 1]]) / size, axis=1)
    graph = csr_array((lengths, (edges[:, 0], edges[:, 1])), shape=(len(points), len(points)))
    distance = dijkstra(graph, directed=False, indices=[centre])[0] * size
    if np.isfinite(distance).sum() < count:
        distance = np.linalg.norm((points - points[centre]) / size, axis=1) * size
    return np.asarray(distance)


def _normal(welded: Surface, members: IntArray, reach: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return the mean normal, the inner points counting more; a random direction where normals cancel."""
    scale = np.abs(welded.points).max()
    sums = sum_at_points(area_vectors(welded.points / scale, welded.faces), welded.faces, len(welded.points))
    chance = unit(rng)
    for mean in ((1.0 - reach) @ sums[members], sums[members[0]]):
        length = float(np.linalg.norm(mean))
        if length > 1e-6 * float(np.linalg.norm(sums[members], axis=1).sum()):
            return np.asarray(mean / length)
    return chance
