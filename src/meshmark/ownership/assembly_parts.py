"""The parts of an assembly that are large enough for a mark of their own: connected components of its surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.components import connected_components
from meshmark.geometry.joints import joints_of
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.ownership.points.moments_apart import moments_apart, stretched
from meshmark.ownership.points.parameters import MOST_POINTS

__all__ = ["LEAST_POINTS", "MOST_PARTS", "AssemblyPart", "assembly_parts", "parts_held_apart"]

# Components of at least this many points are marked and read on their own, the largest first; and at most how many.
LEAST_POINTS, MOST_PARTS = 300, 32
# A part whose moments agree better than they should by this is stretched: rounding and marks change less.
CLOSER = 1e-5


@dataclass(frozen=True, eq=False, kw_only=True)
class AssemblyPart:
    """A connected component of a surface.

    rows: (k,) its points among those of the whole; faces: (m, 3) in these. still: (k,) points that must stay where
    they are beside others, because they touch another component.
    """

    rows: IntArray
    faces: IntArray
    still: NDArray[np.bool_]

    def surface(self, points: FloatArray) -> Surface | None:
        """Return the part's surface where the points (p, 3) of the whole are there; None where two of it meet."""
        surface = surface_of(Mesh(points[self.rows], self.faces))
        return surface if len(surface.points) == len(self.rows) else None


def assembly_parts(surface: Surface) -> tuple[AssemblyPart, ...]:
    """Return the large components of a surface, most points first; none of a surface that is in one piece.

    Parameters
    ----------
    surface : Surface
    """
    count, label = connected_components(surface.graph)
    size = np.bincount(label[surface.used], minlength=count)
    large = np.argsort(-size, kind="stable")[:MOST_PARTS]
    large = large[(size[large] >= LEAST_POINTS) & (size[large] <= MOST_POINTS)]
    if np.count_nonzero(size) < 2 or not len(large):
        return ()
    joints = joints_of(surface).tocoo()
    across = label[joints.row] != label[joints.col]
    still = np.zeros(len(label), bool)
    still[joints.row[across]] = True
    still[joints.col[across]] = True
    of_face = label[surface.faces[:, 0]]
    parts = []
    for each in large:
        rows, corners = np.unique(surface.faces[of_face == each], return_inverse=True)
        parts.append(AssemblyPart(rows=rows, faces=corners.reshape(-1, 3), still=still[rows]))
    return tuple(parts)


def parts_held_apart(points: FloatArray, parts: tuple[AssemblyPart, ...], budget: float) -> FloatArray:
    """Return the points (p, 3) of a surface with round parts stretched a little, so that their frames hold still.

    Parameters
    ----------
    points : (p, 3) float array
    parts : tuple of AssemblyPart
    budget : float
        RMS displacement that a part's points may be given for it, about, in scene units.

    Returns
    -------
    (p, 3) float array
        The same array where no part is round.
    """
    moved = points
    for part in parts:
        surface = part.surface(points)
        if surface is None:
            continue
        frame = surface.frame
        moments = moments_apart(frame, budget / frame.scale)
        if np.abs(moments - frame.moments).max() <= CLOSER:
            continue
        own = frame.to_scene(stretched(frame.to_canonical(surface.points), frame, moments))
        moved = moved.copy() if moved is points else moved
        moved[part.rows] = np.where(part.still[:, None], points[part.rows], own)
    return moved
