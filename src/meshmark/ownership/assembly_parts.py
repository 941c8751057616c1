"""The parts of an assembly that are large enough for a mark of their own: connected components of its surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.joints import joints_of
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.ownership.large_components import MOST_MARKED, large_components
from meshmark.ownership.points.moments_apart import moments_apart, stretched
from meshmark.ownership.points.parameters import MOST_POINTS

__all__ = ["AssemblyPart", "assembly_parts", "parts_held_apart"]

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
    components = large_components(surface, MOST_MARKED)
    if not components:
        return ()
    joints = joints_of(surface).tocoo()
    parts = []
    for component in components:
        if np.count_nonzero(component) > MOST_POINTS:
            continue
        touching = component[joints.row] != component[joints.col]
        still = np.zeros(len(component), bool)
        still[joints.row[touching]] = True
        still[joints.col[touching]] = True
        rows, corners = np.unique(surface.faces[component[surface.faces[:, 0]]], return_inverse=True)
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
