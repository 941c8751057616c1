"""Change of the shading of a surface: the angle between normals at matched points (docs/design.md, section 11)."""

from __future__ import annotations

import numpy as np

from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.metrics.measured_surface import surface_of

__all__ = ["normal_deviation_deg"]


def normal_deviation_deg(a: Mesh, b: Mesh) -> float:
    """Return the mean angle between the normals of `b` and of `a` at the closest points, in degrees, 0 to 180.

    Normals at points are the area-weighted means of the faces there; between the corners of a face of `a` they are
    interpolated, as a renderer does. Each point of `b` weighs as much as the area around it; points without a
    normal on either side are left out. Any connectivity. Raises `InputError` where a model has no surface, or no
    point has normals on both sides.
    """
    original, judged = surface_of(a), surface_of(b)
    if judged.equals(original):  # where sheets coincide the closest point may lie on another one
        return 0.0
    nearest = judged.nearest_on(original)
    corners = original.faces[nearest.faces]
    areas, normals = judged.areas_and_normals
    theirs = np.einsum("nc,nck->nk", nearest.weights, original.areas_and_normals[1][corners])
    along = np.einsum("ij,ij->i", normals, theirs)
    across = np.linalg.norm(np.cross(normals, theirs), axis=1)
    weight = np.where((along == 0.0) & (across == 0.0), 0.0, areas)
    if not (total := weight.sum()):
        raise InputError("no point has a normal on both models, expected surfaces with an area")
    return float(np.degrees(np.arctan2(across, along) @ weight / total))
