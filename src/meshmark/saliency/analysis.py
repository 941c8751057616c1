"""Saliency of a whole model, per vertex of its file."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.saliency.nc_dgg import Saliency, saliency
from meshmark.saliency.salient_points import salient_points

__all__ = ["SaliencyResult", "analyse", "points_and_saliency"]


@dataclass(frozen=True, eq=False, kw_only=True)
class SaliencyResult:
    """What `meshmark saliency` reports.

    beta:     (n,) saliency in [0, 1] of each vertex of the file; vertices that coincide share it.
    salient:  (k,) vertices at the salient points, the strongest first; one vertex for each point.
    seconds:  time taken, paper eq. 16.
    """

    beta: FloatArray
    salient: IntArray
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields `vertices`, `salient_points` and `seconds`."""
        strongest = [{"vertex": int(v), "beta": float(self.beta[v])} for v in self.salient]
        return {"vertices": len(self.beta), "salient_points": strongest, "seconds": self.seconds}


def analyse(mesh: Mesh) -> SaliencyResult:
    """Return the NC-DGG saliency of `mesh` and its salient points.

    Parameters
    ----------
    mesh : Mesh
        A surface of n vertices, closed or open.

    Returns
    -------
    SaliencyResult
        `beta` (n,) in [0, 1], and the salient points, the strongest first.

    Raises
    ------
    InputError
        There is no triangle with three different points.
    """
    began = time.perf_counter()
    welded, found = points_and_saliency(mesh)
    peaks = salient_points(found.beta, welded.points, found.walk, rings=found.rings)
    beta = found.beta[welded.point_of_vertex]
    return SaliencyResult(
        beta=beta, salient=welded.vertex_of_point[peaks], seconds=time.perf_counter() - began
    )


def points_and_saliency(mesh: Mesh) -> tuple[Surface, Saliency]:
    """Return the welded mesh, in a unit of about its size, and its saliency, which no unit changes.

    The unit is a power of two, so that nothing is rounded, and squares of areas stay in the range of floats. Raises
    `InputError` where there is no proper triangle.
    """
    welded = weld(mesh)
    if not len(welded.faces):
        given = f"{len(mesh.faces)} faces, none with three different points"
        raise InputError(f"the model has {given}, expected a surface")
    size = max(float(np.abs(welded.points[welded.faces]).max()), np.finfo(float).tiny)
    scaled = welded.moved(np.ldexp(welded.points, -int(np.frexp(size)[1])))
    return scaled, saliency(scaled.points, scaled.faces)
