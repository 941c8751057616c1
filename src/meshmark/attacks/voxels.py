"""The model turned into a signed distance field on a grid, and back into a surface by marching cubes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.optional_library import library
from meshmark.attacks.voxel_distance import band_distance, split_triangles
from meshmark.attacks.voxel_winding import solid_nodes
from meshmark.errors import InputError
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["voxels"]

COARSEST, FINEST = 4, 512
MARGIN = 3
BAND = 1.1
"""Voxels from the surface up to which distances are exact; a grid edge that crosses it ends within 1."""
HALF_SHEET = 0.6
"""Half the thickness, in voxels, that sheets get; 0.5 would just keep them from falling apart."""
NUDGE = 1e-3
"""No node is taken to lie nearer to the surface, which would make triangles of no area."""


def voxels(mesh: Mesh, strength: float, rng: np.random.Generator, _given: Given) -> Attacked:
    """Rebuild the surface from a grid of `strength` (4 to 512) voxels along the longest side, placed at random.

    Solid is what the surface winds around as seen along two of the three axes: holes are closed straight across,
    parts that overlap become one. Faces with nothing solid near them (open sheets) get a thickness of 1.2 voxels.
    Parts thinner than a voxel may tear or vanish, as in any such tool. No vertex has an origin. A model that is
    wound inside out comes back so.

    Raises `InputError` for a strength that is no whole number in range, a model without extent or too thin for the
    grid, and where scikit-image is missing.
    """
    if strength != int(strength) or not COARSEST <= strength <= FINEST:
        raise InputError(
            f"strength {strength:g} is out of range, expected {COARSEST} to {FINEST} whole voxels"
        )
    measure = library("skimage.measure", "attacks")
    welded = weld(mesh)
    used, corners = np.unique(welded.faces, return_inverse=True)
    points, faces = welded.points[used], corners.reshape(-1, 3)
    side = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if side == 0.0:
        raise InputError("the model has no faces, expected a surface to sample")
    voxel, corner = side / strength, points.min(axis=0)
    phase = MARGIN + rng.random(3)
    placed = (points - corner) / voxel + phase
    inverted = (
        _volume(placed - placed.mean(axis=0), faces) < -1.0
    )  # in voxels; a flat sheet has none to speak of
    field = _signed_distance(placed, faces[:, ::-1] if inverted else faces)
    if field.min() > 0.0:
        raise InputError(
            f"the model is too thin for {strength:g} voxels along its longest side, expected more"
        )
    new_points, new_faces, _, _ = measure.marching_cubes(field, 0.0, gradient_direction="descent")
    new_faces = new_faces[:, ::-1] if inverted else new_faces
    scene = (new_points.astype(np.float64) - phase) * voxel + corner
    return Attacked(mesh=Mesh(scene, new_faces.astype(np.int64)), origin=None)


def _volume(points: FloatArray, faces: IntArray) -> float:
    a, b, c = points[faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def _signed_distance(points: FloatArray, faces: IntArray) -> NDArray[np.float32]:
    """Return the distances of the nodes of a grid that starts at 0, negative in what is solid."""
    high = np.ceil(points.max(axis=0)).astype(np.int64) + MARGIN + 1
    shape = (int(high[0]), int(high[1]), int(high[2]))
    solid = solid_nodes(points, faces, shape)
    single = np.unique(np.sort(faces, axis=1), axis=0)  # polygon soups hold many faces twice
    triangles = split_triangles(points[single])
    sheet = _far_from(solid, triangles.mean(axis=1))
    field = band_distance(triangles[~sheet], shape, BAND)
    shell = band_distance(triangles[sheet], shape, HALF_SHEET + BAND) if sheet.any() else None
    if shell is not None:
        np.minimum(field, shell, out=field)  # the faces that bound a solid and those that do not, together
    np.maximum(field, NUDGE, out=field)
    np.negative(field, where=solid, out=field)
    if shell is not None:
        shell -= np.float32(HALF_SHEET)
        shell[np.abs(shell) < NUDGE] = NUDGE
        np.minimum(field, shell, out=field)
    return field


def _far_from(solid: NDArray[np.bool_], places: FloatArray) -> NDArray[np.bool_]:
    """Return (t,): whether none of the 27 nodes around each place (t, 3) is solid."""
    node = np.rint(places).astype(np.int64).T
    near = np.zeros(len(places), bool)
    for step in np.ndindex(3, 3, 3):
        i, j, k = node + np.reshape(step, (3, 1)) - 1
        near |= solid[i, j, k]
    return ~near
