"""Signed distances (negative inside) of a few solids, and smooth ways to join them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def turn(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Array:
    """Return the rotation by `x`, then `y`, then `z` degrees about the axes."""
    out = np.eye(3)
    for axis, angle in enumerate(np.radians([x, y, z])):
        i, j = [k for k in range(3) if k != axis]
        step = np.eye(3)
        step[[i, j], [i, j]] = np.cos(angle)
        sign = 1.0 if axis == 1 else -1.0
        step[i, j], step[j, i] = sign * np.sin(angle), -sign * np.sin(angle)
        out = step @ out
    return out


def ellipsoid(p: Array, centre: Array, radii: Array, rotation: Array | None = None) -> Array:
    """Return the distance to an ellipsoid, exact on the surface and nearly so around it."""
    q = p - centre
    if rotation is not None:
        q = q @ rotation  # into the ellipsoid's own axes
    near = np.linalg.norm(q / radii, axis=-1)
    slope = np.linalg.norm(q / radii**2, axis=-1)
    return near * (near - 1.0) / np.maximum(slope, 1e-9)


def limb(p: Array, a: Array, b: Array, ra: float, rb: float) -> Array:
    """Return the distance to a rod from `a` to `b` whose radius runs from `ra` to `rb`."""
    along = b - a
    t = np.clip((p - a) @ along / (along @ along), 0.0, 1.0)
    return np.linalg.norm(p - a - t[..., None] * along, axis=-1) - (ra + (rb - ra) * t)


def leaf(p: Array, curve: Array, out: Array, width: Array, thickness: Array, cup: float) -> Array:
    """Return the distance to a cupped leaf along a curve (n, 3); `out` (n, 3) points to its hollow side."""
    best = np.full(p.shape[:-1], np.inf)
    t = np.zeros(p.shape[:-1])
    for i in range(len(curve) - 1):
        step = curve[i + 1] - curve[i]
        s = np.clip((p - curve[i]) @ step / (step @ step), 0.0, 1.0)
        distance = np.linalg.norm(p - curve[i] - s[..., None] * step, axis=-1)
        closer = distance < best
        best, t = np.where(closer, distance, best), np.where(closer, i + s, t)
    knots = np.arange(len(curve))

    def at(values: Array) -> Array:
        return np.stack([np.interp(t, knots, column) for column in values.T], axis=-1)

    offset, facing = p - at(curve), at(out)
    tangent = at(np.gradient(curve, axis=0))
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    facing -= np.sum(facing * tangent, axis=-1, keepdims=True) * tangent
    facing /= np.linalg.norm(facing, axis=-1, keepdims=True)
    side = np.cross(tangent, facing)
    half, flat = np.interp(t, knots, width), np.interp(t, knots, thickness)
    u = np.sum(offset * side, axis=-1) / half
    w = np.sum(offset * facing, axis=-1)
    lift = cup * half * np.minimum(u * u, 1.5)
    across = np.stack([u * half, w - lift, np.sum(offset * tangent, axis=-1)], axis=-1)
    radii = np.stack([half, flat, np.minimum(half, flat)], axis=-1)
    # an exponent above 2 rounds the rims, which an ellipse would leave too sharp for the mesh
    near = np.sum(np.abs(across / radii) ** 3, axis=-1) ** (1 / 3)
    steep = np.linalg.norm((across / radii) ** 2 / radii, axis=-1)
    return near**2 * (near - 1.0) / np.maximum(steep, 1e-9)


def join(a: Array, b: Array, blend: float) -> Array:
    """Return the union of two solids with a fillet of about `blend`."""
    h = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.minimum(a, b) - h * h * h * blend / 6.0


def carve(a: Array, b: Array, blend: float) -> Array:
    """Return solid `a` without solid `b`, with a rounded edge."""
    return -join(-a, b, blend)
