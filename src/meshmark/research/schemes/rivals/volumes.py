"""Volume moments of closed surfaces: a canonical frame, and how much of the volume lies in which direction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from meshmark.geometry.frame import signed_axes
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Solid", "directions", "memberships", "signed_volumes", "solid_of", "spacing", "volumes"]

# Directions share what lies within this number of spacings of them, up to a largest number of directions.
REACH, MOST = 1.6, 12
# Faces are cut into pieces of about this many spacings, by halving their edges so often at most.
PIECE, HALVINGS = 0.25, 4


def signed_volumes(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m,): the signed volume of the tetrahedron of each face and the origin."""
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return np.asarray(np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class Solid:
    """What is inside a closed surface, to the second order: volume, centroid (3,), covariance (3, 3)."""

    volume: float
    centre: FloatArray
    covariance: FloatArray

    def axes(self) -> FloatArray:
        """Return (3, 3): columns take a place from the centroid to principal axes along which the variance is 1."""
        values, vectors = np.linalg.eigh(self.covariance)
        return np.asarray((vectors / np.sqrt(values))[:, ::-1])


def solid_of(points: FloatArray, faces: IntArray) -> tuple[Solid, FloatArray] | None:
    """Return the solid inside a closed surface and its `axes`, their signs by the third moments along them.

    None where there is no volume.
    """
    middle = points.mean(axis=0)
    centre = middle + _integrals(points - middle, faces)[1]
    volume, _, second, _ = _integrals(points - centre, faces)
    solid = Solid(volume=volume, centre=centre, covariance=second)
    if volume == 0.0 or not np.linalg.eigvalsh(second)[0] > 0.0:
        return None
    axes = solid.axes()
    third = _integrals((points - centre) @ axes, faces)[3]
    return solid, axes * np.sign(np.einsum("ij,ij->j", axes, signed_axes(axes, third)))


def _integrals(points: FloatArray, faces: IntArray) -> tuple[float, FloatArray, FloatArray, FloatArray]:
    """Return volume, and per unit of it the means of x (3,), x x' (3, 3) and x^3, y^3, z^3 (3,)."""
    corners = [points[faces[:, corner]] for corner in range(3)]
    parts = signed_volumes(points, faces)
    volume = float(parts.sum())
    shares = parts / volume if volume != 0.0 else parts
    total = corners[0] + corners[1] + corners[2]
    second = total.T @ (shares[:, None] * total)
    squares, cubes = np.zeros_like(total), np.zeros_like(total)
    for corner in corners:
        second += corner.T @ (shares[:, None] * corner)
        squares += corner * corner
        cubes += corner**3
    # x^k over a tetrahedron is 3! k! / (3 + k)! times the complete homogeneous polynomial of its corners.
    third = (total**3 + 3.0 * total * squares + 2.0 * cubes) / 6.0
    return volume, shares @ total / 4.0, second / 20.0, shares @ third / 20.0


@lru_cache(maxsize=4)
def directions(count: int) -> cKDTree:
    """Return unit vectors (count, 3), spread evenly over all directions, as a tree."""
    number = np.arange(count)
    z = 1.0 - (2.0 * number + 1.0) / count
    angle, flat = np.pi * (3.0 - np.sqrt(5.0)) * number, np.sqrt(1.0 - z * z)
    return cKDTree(np.column_stack([flat * np.cos(angle), flat * np.sin(angle), z]))


def spacing(count: int) -> float:
    """Return about how far apart this number of directions are."""
    return float(np.sqrt(4.0 * np.pi / count))


def memberships(places: FloatArray, count: int) -> csr_array:
    """Return how much each place (n, 3), seen from the origin, belongs to each of `count` directions, (n, count).

    Smooth in the place, with sum 1; the same along a ray.
    """
    which, weights = _nearest(places, count)
    starts = np.arange(0, which.size + 1, MOST)
    return csr_array((weights.ravel(), which.ravel(), starts), shape=(len(places), count))


def _nearest(places: FloatArray, count: int) -> tuple[IntArray, FloatArray]:
    """Return the directions nearest to each place and how much it belongs to them, (n, MOST) each."""
    radii = np.sqrt(np.einsum("ij,ij->i", places, places))
    unit = places / np.where(radii > 0.0, radii, 1.0)[:, None]
    far, which = directions(count).query(unit, k=MOST)
    weights = np.maximum(1.0 - (far / (REACH * spacing(count))) ** 2, 0.0) ** 2
    weights[:, 0] += 1e-12  # the nearest has what no direction reaches: a place at the origin
    weights /= weights.sum(axis=1, keepdims=True)
    return np.asarray(which, np.int64), np.asarray(weights)


def volumes(points: FloatArray, faces: IntArray, count: int) -> FloatArray:
    """Return (count,): how much of the volume inside lies in each direction from the origin."""
    parts = signed_volumes(points, faces)
    radii = np.linalg.norm(points, axis=1)
    unit = points / np.where(radii > 0.0, radii, 1.0)[:, None]
    longest = np.max(
        [np.linalg.norm(unit[faces[:, i]] - unit[faces[:, i - 1]], axis=1) for i in range(3)], axis=0
    )
    wanted = np.log2(np.maximum(longest / (PIECE * spacing(count)), 1.0))
    halvings = np.minimum(np.ceil(wanted), HALVINGS).astype(int)
    total = np.zeros(count)
    for level in np.unique(halvings):
        these = halvings == level
        middles = _middles(2 ** int(level))
        places = np.einsum("qc,fcx->fqx", middles, points[faces[these]]).reshape(-1, 3)
        shares = np.repeat(parts[these] / len(middles), len(middles))
        which, weights = _nearest(places, count)
        total += np.bincount(which.ravel(), (weights * shares[:, None]).ravel(), count)
    return total


def _middles(cuts: int) -> FloatArray:
    """Return barycentric coordinates (cuts^2, 3) of the middles of the like pieces of a triangle."""
    i, j = np.divmod(np.arange(cuts * cuts), cuts)
    up = i + j < cuts
    u = np.where(up, i + 1.0 / 3.0, cuts - i - 1.0 / 3.0)
    v = np.where(up, j + 1.0 / 3.0, cuts - j - 1.0 / 3.0)
    return np.column_stack([u, v, cuts - u - v]) / cuts
