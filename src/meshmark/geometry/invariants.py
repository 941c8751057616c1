"""Numbers that a shape keeps when it is turned, scaled, moved, mirrored, meshed anew or slightly damaged.

All are averages over the surface, in the canonical frame's unit (root mean square distance from the centroid), and
none depends on the direction of an axis. Notation: x is a place of the surface, r = |x|, z = x / sqrt(1 + r^2) the
same place drawn into the unit ball, so that far protrusions count little; E is the mean by area.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from meshmark.geometry.blocks import LARGE, blocks
from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.geometry.sampling import plan_samples
from meshmark.mesh import FloatArray, IntArray

__all__ = ["INVARIANTS", "sampled_invariants", "shape_invariants"]

INVARIANTS: Final = (
    *(f"moment {i}" for i in (1, 2, 3)),
    "area",
    "mean r",
    "mean r^4",
    "mean z",
    "mean z |z|^2",
    "mean z z z",
    *(f"covariance of z z, share {i}" for i in (1, 2, 3, 4, 5, 6)),
    "covariance of z z, trace",
)
"""Names of the numbers that `shape_invariants` returns; each is a logarithm."""

# A sample of the surface is no longer than this, in the frame's unit (quadrature error of the numbers below 0.01).
LONGEST: Final = 0.1
# Added before a logarithm is taken: what is smaller than these says nothing, of flat and of symmetric shapes.
LEAST_SHARE: Final = 1e-3
LEAST_SKEW: Final = 0.03
TINY: Final = 1e-6


def shape_invariants(
    points: FloatArray, faces: IntArray, frame: Frame | None = None, lengths: FloatArray | None = None
) -> FloatArray:
    """Return the numbers named in `INVARIANTS` of a surface.

    Parameters
    ----------
    points : (p, 3) float array
        Positions in any unit.
    faces : (m, 3) int array
        Triangles; their orientation does not matter.
    frame : Frame, optional
        The canonical frame of the surface, where it is known already.
    lengths : (m,) float array, optional
        The longest edge of each face in the unit of the points, where it is known already.

    Returns
    -------
    (16,) float array
        Natural logarithms: of the second moments' shares, of the area in squared units of the frame's scale, of the
        means of r and r^4, of the lengths of the third-order averages (with `LEAST_SKEW` added), and of the
        eigenvalues of the covariance of the six products of two coordinates of z.

    Raises
    ------
    InputError
        There is no surface.
    """
    frame = canonical_frame(points, faces) if frame is None else frame
    canonical = frame.to_canonical(points)
    known = None if lengths is None else lengths / frame.scale
    samples = plan_samples(canonical, faces, LONGEST, known)(canonical)
    return sampled_invariants(samples.positions, samples.areas, frame)


def sampled_invariants(positions: FloatArray, areas: FloatArray, frame: Frame) -> FloatArray:
    """Return the numbers (16,) of `shape_invariants` of a surface in its frame, of which there are samples.

    positions: (q, 3) canonical; areas: (q,) in any unit, which samples stand for.
    """
    whole = areas.sum()
    radius, fourth, first = 0.0, 0.0, np.zeros(3)
    mean, second, cubes = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 3))
    for part in blocks(len(areas), LARGE):
        weight = areas[part] / whole
        x = np.ascontiguousarray(positions[part].T)
        square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2]
        z = x / np.sqrt(1.0 + square)
        radius += float(np.sqrt(square) @ weight)
        fourth += float(square**2 @ weight)
        first += z @ weight
        products = _products(z)
        mean += products @ weight
        second += (products * weight) @ products.T
        cubes += products @ (z * weight).T  # the mean of z z z, its entries off the diagonal times sqrt 2
    shares = np.maximum(np.linalg.eigvalsh(second - np.outer(mean, mean))[::-1], 0.0)
    trace = float(shares.sum())
    skew = [first, cubes[:3].sum(axis=0), cubes]
    return np.concatenate(
        [
            np.log(frame.moments + LEAST_SHARE),
            np.log([frame.area, radius, fourth]),
            np.log([float(np.sqrt((part**2).sum())) + LEAST_SKEW for part in skew]),
            np.log(shares / max(trace, TINY) + LEAST_SHARE),
            np.log([trace + TINY]),
        ]
    )


def _products(z: FloatArray) -> FloatArray:
    """Return (6, q): products of two coordinates of z (3, q), a rotation of z being a rotation of them (Mandel)."""
    a, b, c = z
    off = np.sqrt(2.0)
    return np.stack([a * a, b * b, c * c, off * a * b, off * a * c, off * b * c])
