"""How visible a change of a surface is, from the change of its normals.

A viewer sees shading, so normals, not positions, and sees a change best where the surface was smooth. In a patch
around each of many points spread over the surface:

    change     RMS angle between the normals before and after, degrees
    detail     RMS angle of the normals before from their best linear fit over the patch, degrees
    ratio      change / (JUST_NOTICED + MASKING detail)

A patch with a ratio above 1 is visible; the visible share is that of the surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from meshmark.geometry.areas import area_vectors, sum_at_points, vertex_area_sums
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.stiffness import diffused
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Visibility", "VisibleChange", "degrees_between"]

# Radius of a patch over the bounding-box diagonal, a change in degrees that is just noticed on a smooth patch, and
# the share of a patch's own detail that hides a change.
RADIUS = 0.025
JUST_NOTICED = 0.75
MASKING = 0.5
PATCHES = 1500
# Points of a patch that are used at most, and at least.
MOST, LEAST = 100, 8
# Faces that point both ways cancel down to this share of their area, by rounding.
CANCELLED = 1e-6
# Normals of one patch: others are of the far side of a thin wall.
SAME_SIDE = 0.3


@dataclass(frozen=True, kw_only=True)
class Visibility:
    """How visible a change is.

    share: of the surface where it is visible, 0 to 1. median, p95: of the ratio over the surface.
    smooth: RMS change of normals, degrees, over the smoothest quarter of the surface.
    """

    share: float
    median: float
    p95: float
    smooth: float


class VisibleChange:
    """The patches of one surface, to judge displacements of its points by.

    Equal points (p, 3) must be one. Patches are spread over the area by a fixed seed.

    centres: (k,) points that patches lie around. noticed: (k,) change in degrees that is just noticed there.
    """

    def __init__(self, points: FloatArray, faces: IntArray) -> None:
        # Areas of very large or small units would leave the range of numbers.
        self._low = points.min(axis=0)
        self._size = float((points - self._low).max()) or 1.0
        points = self._sized(points)
        self._points, self._faces = points, faces
        normals, areas = _normals(points, faces)
        used = np.flatnonzero(areas > 0.0)
        self.centres = _spread(used, areas[used])
        near = _patches(points, normals, used, self.centres)
        counts = np.array([len(each) for each in near])
        members = np.concatenate(near)
        rows = np.repeat(np.arange(PATCHES), counts)
        weight = areas[members] / np.bincount(rows, areas[members])[rows]
        place = points[members] - points[self.centres][rows]
        detail = _detail(place / np.sqrt(np.mean(place**2) + 1e-300), normals[members], weight, rows)
        self.noticed = JUST_NOTICED + MASKING * detail
        self._smooth = detail <= np.quantile(detail, 0.25)
        # Only the members' normals are looked at.
        self._members, columns = np.unique(members, return_inverse=True)
        self._normals = normals[self._members]
        self._mean = sp.csr_array((weight, (rows, columns)), shape=(PATCHES, len(self._members)))

    def _sized(self, points: FloatArray) -> FloatArray:
        return np.asarray((points - self._low) / self._size)

    def noticed_at(self, mass: FloatArray, stiff: sp.csr_array, width: float) -> FloatArray:
        """Return the change in degrees (p,) that is just noticed at each point, patches diffused by `width`.

        mass, stiff: of the surface, as in `diffused`.
        """
        seen = np.zeros((len(self._points), 2))
        seen[self._members] = self._mean.T @ np.column_stack([self.noticed, np.ones(PATCHES)])
        spread = diffused(seen / mass[:, None], mass, stiff, width)
        known = spread[:, 1] > 1e-6 * spread[:, 1].mean()
        average = spread[:, 0] / np.where(known, spread[:, 1], 1.0)
        return np.asarray(np.where(known, average, np.median(self.noticed)))

    def slopes(self, directions: FloatArray) -> sp.csr_array:
        """Return (3 s, p): change of the patches' normals, to first order, per unit of motion along directions.

        directions: (p, 3). What `ratios_of` takes is this matrix times the motion (p,).
        """
        number = np.full(len(self._points), -1)
        number[self._members] = np.arange(len(self._members))
        around = self._faces[(number[self._faces] >= 0).any(axis=1)]
        corners = [self._points.take(around[:, i], axis=0) for i in range(3)]
        size = np.linalg.norm(
            sum_at_points(area_vectors(self._points, around), around, len(self._points))[self._members],
            axis=1,
        )
        rows, columns, values = [], [], []
        for mover in range(3):
            across = corners[(mover + 1) % 3] - corners[(mover + 2) % 3]
            turned = 0.5 * np.cross(directions[around[:, mover]], across)
            for corner in range(3):
                at = number[around[:, corner]]
                seen = at >= 0
                at, change = at[seen], turned[seen]
                normal = self._normals[at]
                change = change - normal * np.einsum("ij,ij->i", change, normal)[:, None]
                change /= np.maximum(size[at] * self._size, 1e-300)[:, None]
                rows.append((3 * at[:, None] + np.arange(3)).ravel())
                columns.append(np.repeat(around[seen, mover], 3))
                values.append(change.ravel())
        shape = (3 * len(self._members), len(self._points))
        return sp.csr_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape
        )

    def ratios_of(self, turned: FloatArray) -> FloatArray:
        """Return the ratio of each patch (k,) for changes of the normals (3 s,), small."""
        square = (turned.reshape(-1, 3) ** 2).sum(axis=1)
        return np.asarray(np.degrees(np.sqrt(self._mean @ square)) / self.noticed)

    def seen(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return (p,): the points of the patches where it is visible that the points (p, 3) are there now."""
        visible = self._change(points) > self.noticed
        seen = np.zeros(len(self._points), bool)
        seen[self._members[self._mean[visible].indices]] = True
        return seen

    def _change(self, points: FloatArray) -> FloatArray:
        """Return the RMS change of the normals of each patch (k,), degrees."""
        normals, _ = _normals(self._sized(points), self._faces)
        angle = degrees_between(normals[self._members], self._normals)
        return np.sqrt(np.asarray(self._mean @ angle**2, dtype=np.float64))

    def of(self, points: FloatArray) -> Visibility:
        """Return how visible it is that the points (p, 3) are there now."""
        change = self._change(points)
        ratio = change / self.noticed
        return Visibility(
            share=float((ratio > 1.0).mean()),
            median=float(np.median(ratio)),
            p95=float(np.quantile(ratio, 0.95)),
            smooth=float(np.sqrt((change[self._smooth] ** 2).mean())),
        )


def degrees_between(normals: FloatArray, others: FloatArray) -> FloatArray:
    """Return the angles (n,) between unit vectors (n, 3) and others, degrees; small ones to full precision."""
    chord = np.linalg.norm(normals - others, axis=1)
    return np.asarray(np.degrees(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0))))


def _normals(points: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the unit normals (p, 3), and the area (p,) that they speak for: none where doubled faces cancel.

    Of a surface that is doubled everywhere each point speaks for its faces; it has no normals that could change.
    """
    areas, summed = vertex_area_sums(points, faces)
    length = np.sqrt(np.einsum("ij,ij->i", summed, summed))
    cancelled = length <= CANCELLED * areas
    summed[cancelled] = 0.0
    weight = areas if cancelled.all() else np.where(cancelled, 0.0, length)
    return summed / np.where(cancelled, 1.0, length)[:, None], weight


def _spread(used: IntArray, areas: FloatArray) -> IntArray:
    """Return points (k,) of those used, spread by area."""
    rng = np.random.default_rng(0)
    share = np.cumsum(areas)
    drawn = (np.arange(PATCHES) + rng.random(PATCHES)) / PATCHES * share[-1]
    return np.asarray(used[np.minimum(np.searchsorted(share, drawn), len(used) - 1)])


def _patches(points: FloatArray, normals: FloatArray, used: IntArray, centres: IntArray) -> list[IntArray]:
    """Return the members of the patch around each centre."""
    radius = RADIUS * float(np.linalg.norm(np.ptp(points[used], axis=0)))
    tree = kd_tree(points[used])
    patches = []
    for centre in centres:  # one by one: of a large model each has tens of thousands
        # Sorted, the every n-th of a fine mesh's points does not depend on the tree.
        members = used[np.sort(tree.query_ball_point(points[centre], radius))]
        members = members[normals[members] @ normals[centre] > SAME_SIDE]
        if len(members) < LEAST:
            members = used[np.atleast_1d(tree.query(points[centre], min(LEAST, len(used)))[1])]
        patches.append(members[:: -(-len(members) // MOST)])
    return patches


def _detail(places: FloatArray, normals: FloatArray, weight: FloatArray, rows: IntArray) -> FloatArray:
    """Return (k,): RMS angle, degrees, of normals (n, 3) from their best linear fit over places in each patch."""
    design = np.column_stack([np.ones(len(places)), places])
    pairs = design[:, :, None] * np.hstack([design, normals])[:, None, :] * weight[:, None, None]
    sums = np.zeros((PATCHES, 4, 7))
    np.add.at(sums, rows, pairs)
    # Ridge: the points of a flat patch do not determine the slope across it.
    fit = np.linalg.solve(sums[:, :, :4] + 1e-9 * np.eye(4), sums[:, :, 4:])
    rest = normals - np.einsum("ni,nij->nj", design, fit[rows])
    return np.degrees(np.sqrt(np.bincount(rows, weight * (rest**2).sum(axis=1), PATCHES)))
