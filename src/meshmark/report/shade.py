"""Light on what the rasteriser saw: smooth normals, three lights, darker hollows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from meshmark.geometry.areas import area_vectors, vertex_area_sums
from meshmark.mesh import FloatArray, IntArray
from meshmark.report.raster import EMPTY

__all__ = ["Seen", "light", "see", "steady_normals"]

CREASE = 0.6
"""A corner whose normal turns from its face's by more than the arc cosine of this is drawn as a crease."""
CANCELLED = 0.1
"""Share of the area around a point that its summed normals come to at least; less is no direction."""
LIGHTS = ((-0.5, 0.62, 0.6, 0.62), (0.75, 0.05, 0.55, 0.2), (0.1, -0.7, 0.3, 0.06))
"""Direction in view space (right, up, towards the viewer) and strength."""
HOLLOWS = 5.0
COARSER = 4
"""Pixels, each way, for one sample of what surrounds a pixel."""
Thin = NDArray[np.float32]


@dataclass(frozen=True, eq=False, kw_only=True)
class Seen:
    """The k pixels that show a surface.

    mask:    (height, width) where they are; the rest is in the order of mask's true pixels.
    faces:   (k, 3) corners of the face at each; face: (k,) its index.
    weights: (k, 3) barycentric coordinates of the pixel in it.
    normals: (k, 3) unit, in view space, towards the viewer.
    depth:   (k,) of the screen.
    """

    mask: NDArray[np.bool_]
    face: IntArray
    faces: IntArray
    weights: Thin
    normals: Thin
    depth: Thin


def see(face_at: IntArray, screen: FloatArray, viewed: FloatArray, faces: IntArray) -> Seen:
    """Return what each pixel shows; `viewed` are the points (p, 3) in view space."""
    mask = face_at != EMPTY
    face = face_at[mask]
    rows, columns = np.nonzero(mask)
    corners = faces.take(face, axis=0)
    weights = _barycentric(screen, corners, np.add(columns, 0.5), np.add(rows, 0.5))
    own = _unit(area_vectors(viewed, faces).astype(np.float32)).take(face, axis=0)
    smooth = steady_normals(viewed, faces).astype(np.float32)
    normals = np.zeros_like(own)
    for corner, weight in zip(corners.T, weights.T, strict=True):
        at = smooth.take(corner, axis=0)
        sharp = np.einsum("ij,ij->i", at, own) < CREASE
        at[sharp] = own[sharp]
        normals += at * weight[:, None]
    normals *= np.where(own[:, 2:] < 0.0, np.float32(-1.0), np.float32(1.0))
    depth = np.einsum("ij,ij->i", screen[:, 2].astype(np.float32).take(corners), weights)
    return Seen(mask=mask, face=face, faces=corners, weights=weights, normals=_unit(normals), depth=depth)


def steady_normals(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return unit normals (p, 3) of points; zeros where faces are there both ways round, so that little is left."""
    areas, summed = vertex_area_sums(points, faces)
    length = np.linalg.norm(summed, axis=1)
    kept = length > CANCELLED * 3.0 * areas
    return np.asarray(summed / np.where(kept, length, np.inf)[:, None])


def _unit(vectors: Thin) -> Thin:
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    unit: Thin = vectors / np.maximum(length, np.finfo(np.float32).tiny)[:, None]
    return unit


def _barycentric(screen: FloatArray, corners: IntArray, x: FloatArray, y: FloatArray) -> Thin:
    (xa, xb, xc), (ya, yb, yc) = (screen[:, axis].take(corners.T) for axis in (0, 1))
    xb, xc, yb, yc, x, y = xb - xa, xc - xa, yb - ya, yc - ya, x - xa, y - ya
    turn = xb * yc - xc * yb
    weights = np.empty((len(corners), 3), np.float32)
    weights[:, 1] = (x * yc - xc * y) / turn
    weights[:, 2] = (xb * y - x * yb) / turn
    weights[:, 0] = 1.0 - weights[:, 1] - weights[:, 2]
    return np.clip(weights, 0.0, 1.0, out=weights)


def light(seen: Seen, colours: Thin) -> Thin:
    """Return (k, 3) linear RGB: `colours` (k, 3) under the lights, hollows darkened, with a faint gloss."""
    strength = 0.20 + 0.10 * seen.normals[:, 1]
    gloss = np.zeros_like(strength)
    for *way, power in LIGHTS:
        towards = np.array(way, np.float32) / np.float32(np.linalg.norm(way))
        strength += power * np.maximum(seen.normals @ towards, 0.0)
        half = towards + np.array([0.0, 0.0, 1.0], np.float32)
        half /= np.linalg.norm(half)
        shine = np.maximum(seen.normals @ half, 0.0) ** 2
        gloss += power * ((shine**2) ** 2) ** 5
    lit = colours * (strength * _openness(seen))[:, None] + 0.05 * gloss[:, None]
    return lit.astype(np.float32, copy=False)


def _openness(seen: Seen) -> Thin:
    """Return (k,) factors below 1 where the surface lies behind what surrounds it on the screen."""
    height, width = seen.mask.shape
    depth = np.ones((height, width), np.float32)
    depth[seen.mask] = seen.depth
    openness = np.ones(len(seen.depth), np.float32)
    for reach in (0.006, 0.02):
        around = gaussian_filter(depth[::COARSER, ::COARSER], reach * max(height, width) / COARSER)
        around = around.repeat(COARSER, axis=0).repeat(COARSER, axis=1)[:height, :width]
        openness /= 1.0 + HOLLOWS * np.maximum(seen.depth - around[seen.mask], 0.0)
    return openness
