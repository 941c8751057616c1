"""The closest point of a triangle to a point, for many pairs at once; triangles may have no area."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Triangles"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Triangles:
    """Triangles as a corner (m, 3) and the two edges that leave it (m, 3)."""

    corner: FloatArray
    first: FloatArray
    second: FloatArray

    @classmethod
    def of(cls, points: FloatArray, faces: IntArray) -> Triangles:
        """Return the triangles of a mesh."""
        a, b, c = (points.take(column, axis=0) for column in faces.T)
        return cls(corner=a, first=b - a, second=c - a)

    def closest(self, queries: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the distance of each query (n, 3) to the face (n,) named beside it, and where it is closest.

        The place (n, 2) is the share of the second and third corner; the first has the rest. The best of the three
        sides and of the foot of the perpendicular is taken, by its true distance: triangles that are a
        line or a point need no case of their own.
        """
        distances = np.empty(len(queries))
        shares = np.empty((len(queries), 2))
        for part in blocks(len(queries), 1 << 13):
            at = faces[part]
            distances[part], shares[part] = _closest(
                (queries[part] - self.corner.take(at, axis=0)).T,
                self.first.take(at, axis=0).T,
                self.second.take(at, axis=0).T,
            )
        return distances, shares


def _closest(p: FloatArray, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Closest points to `p` (3, n) among corners 0, u, v: distances (n,) and shares of u and v (n, 2)."""
    p, u, v = (np.ascontiguousarray(x) for x in (p, u, v))
    uu, uv, vv, pu, pv = _dot(u, u), _dot(u, v), _dot(v, v), _dot(p, u), _dot(p, v)
    none = np.zeros_like(pu)
    on_u = _clipped_ratio(pu, uu)
    on_v = _clipped_ratio(pv, vv)
    on_side = _clipped_ratio(_dot(p - u, v - u), _dot(v - u, v - u))
    best = _squared(p, u, v, on_u, none)
    shares = np.stack([on_u, none], axis=1)
    determinant = uu * vv - uv * uv
    with np.errstate(divide="ignore", invalid="ignore"):
        inside_u = (vv * pu - uv * pv) / determinant
        inside_v = (uu * pv - uv * pu) / determinant
        outside = ~((inside_u >= 0.0) & (inside_v >= 0.0) & (inside_u + inside_v <= 1.0))
    inside_u[outside] = 0.0
    inside_v[outside] = 0.0
    for s, t in ((none, on_v), (1.0 - on_side, on_side), (inside_u, inside_v)):
        distance = _squared(p, u, v, s, t)
        better = distance < best
        best[better] = distance[better]
        shares[better, 0] = s[better]
        shares[better, 1] = t[better]
    return np.sqrt(best), shares


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    out: FloatArray = a[0] * b[0]
    out += a[1] * b[1]
    out += a[2] * b[2]
    return out


def _squared(p: FloatArray, u: FloatArray, v: FloatArray, s: FloatArray, t: FloatArray) -> FloatArray:
    """Squared distance of p from the point s u + t v."""
    out = np.zeros_like(s)
    for i in range(3):
        out += np.square(p[i] - s * u[i] - t * v[i])
    return out


def _clipped_ratio(part: FloatArray, whole: FloatArray) -> FloatArray:
    """Return part / whole within 0 to 1; 0 where the whole is 0."""
    ratio: FloatArray = np.clip(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0), 0.0, 1.0)
    return ratio
