"""Sample points that stand for the surface in integrals against smooth windows.

Where triangles are small against the window a point takes a third of the area of the faces around it; larger
triangles are split. Both are second-order quadratures, so refining a mesh hardly changes what is measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from meshmark.geometry.areas import add_at_points, area_fluxes, face_lengths
from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Sampler", "SamplerPlans", "Samples", "gathered", "plan_samples"]

# At most: pieces that a face is split into each way, and, about, samples of all faces together. Huge or very
# spiky surfaces cannot exhaust memory; the window then sees a coarser sum.
MAX_SPLIT = 256
MAX_SAMPLES = 1_500_000
ROUNDING = 1e-9
# Cubes of a model that is so far spread out have no numbers.
MOST_CUBES = 2.0**60


@dataclass(frozen=True, eq=False, kw_only=True)
class Samples:
    """Positions (q, 3), area vectors (q, 3) and areas (q,) of the samples of one set of point positions."""

    positions: FloatArray
    vectors: FloatArray
    areas: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Sampler:
    """Which samples a mesh gets; fixed once, so that moving points moves samples smoothly.

    faces: (m, 3); coarse: (c,) faces that are split; split_face (q',), split_weights (q', 3) barycentric,
    split_share (q',) share of the face's area. The first samples are the points, the others the splits.
    """

    faces: IntArray
    count: int
    fine: NDArray[np.int32]
    split_face: IntArray
    split_weights: FloatArray
    split_share: FloatArray

    def __call__(self, points: FloatArray) -> Samples:
        """Return the samples for positions (p, 3)."""
        lumped = np.zeros((self.count, 4))
        for part in blocks(len(self.fine)):
            fine = self.faces[self.fine[part]]
            add_at_points(lumped, area_fluxes(points, fine) * (1.0 / 3.0), fine)
        if not len(self.split_face):
            return Samples(positions=points, vectors=lumped[:, :3], areas=lumped[:, 3])
        pieces = self.split_share[:, None] * area_fluxes(points, self.faces[self.split_face])
        return Samples(
            positions=np.concatenate([points, self._middle @ points]),
            vectors=np.concatenate([lumped[:, :3], pieces[:, :3]]),
            areas=np.concatenate([lumped[:, 3], pieces[:, 3]]),
        )

    @cached_property
    def _middle(self) -> sp.csr_array:
        """(q', p): the barycentric weights of each split."""
        rows = np.arange(0, 3 * len(self.split_face) + 1, 3)
        corners = self.faces[self.split_face].ravel()
        shape = (len(self.split_face), self.count)
        return sp.csr_array((self.split_weights.ravel(), corners, rows), shape=shape)

    def normal_motion(self, samples: Samples, normals: FloatArray) -> sp.csr_array:
        """Return (q, p): flux through each sample per unit of displacement of each point along its normal."""
        lumped = np.einsum("ij,ij->i", normals, samples.vectors[: self.count])
        if not len(self.split_face):
            return sp.csr_array(sp.diags_array(lumped))
        rows = self.count + np.repeat(np.arange(len(self.split_face)), 3)
        columns = self.faces[self.split_face].ravel()
        along = np.einsum("qij,qj->qi", normals[self.faces[self.split_face]], samples.vectors[self.count :])
        values = (along * self.split_weights).ravel()
        index = np.arange(self.count)
        return sp.csr_array(
            (
                np.concatenate([lumped, values]),
                (np.concatenate([index, rows]), np.concatenate([index, columns])),
            ),
            shape=(self.count + len(self.split_face), self.count),
        )


class SamplerPlans:
    """Samplers of one mesh for several lengths of the longest piece, each planned once; one where no face is split.

    lengths: (m,) `face_lengths` of the faces (m, 3).
    """

    def __init__(self, faces: IntArray, lengths: FloatArray) -> None:
        self._faces, self._lengths = faces, lengths
        self._longest = float(lengths.max(initial=0.0))
        self._known: dict[float, Sampler] = {}

    def plan(self, points: FloatArray, longest: float) -> Sampler:
        """Return what `plan_samples` does for points (p, 3) of these lengths."""
        split = min(longest, self._longest)  # any longer one splits no face either
        if split not in self._known:
            self._known[split] = plan_samples(points, self._faces, split, self._lengths)
        return self._known[split]


def gathered(samples: Samples, size: float) -> Samples:
    """Return fewer samples: one for each cube of edge `size` and direction of facing, at the mean place.

    The six directions (the largest part of the area vector, and its sign) keep the sheets of a thin wall apart.
    """
    if not len(samples.areas):
        return samples
    # By coordinates, each in one piece: sums over three numbers at a time take many times as long.
    positions, vectors = np.ascontiguousarray(samples.positions.T), np.ascontiguousarray(samples.vectors.T)
    cube = np.floor(positions / size).astype(np.int64)
    cube -= cube.min(axis=1, keepdims=True)
    x, y, z = np.abs(vectors)
    facing = np.where(z > np.maximum(x, y), 2, (y > x).astype(np.int64))
    backwards = np.choose(facing, vectors) < 0.0
    across = cube.max(axis=1) + 1
    places = 6.0 * float(np.prod(across.astype(np.float64)))
    if places > MOST_CUBES:
        return samples
    name = ((cube[0] * across[1] + cube[1]) * across[2] + cube[2]) * 6 + 2 * facing + backwards
    group = _numbered(name, int(places))
    areas = np.bincount(group, samples.areas).astype(np.float64)
    shares = samples.areas / np.where(areas > 0.0, areas, 1.0)[group]
    return Samples(
        positions=np.stack([np.bincount(group, shares * axis) for axis in positions], axis=1),
        vectors=np.stack([np.bincount(group, axis) for axis in vectors], axis=1),
        areas=areas,
    )


def _numbered(names: IntArray, count: int) -> IntArray:
    """Return (n,): names in [0, count) as numbers 0, 1, ... in their order; by a table where that is small."""
    if count > 16 * len(names) + 1024:
        return np.asarray(np.unique(names, return_inverse=True)[1])
    used = np.zeros(count, dtype=bool)
    used[names] = True
    return np.asarray((np.cumsum(used, dtype=np.int32) - 1)[names], np.int64)


def plan_samples(
    points: FloatArray, faces: IntArray, longest: float, lengths: FloatArray | None = None
) -> Sampler:
    """Choose samples so that, up to a limit on their number, no piece is longer than `longest` from end to end.

    lengths: (m,) `face_lengths` of the faces in the unit of the points, where they are known already.
    """
    large = (face_lengths(points, faces) if lengths is None else lengths) > longest
    corners = np.stack([points[faces[large, i]] for i in range(3)])
    ways = np.roll(corners, -1, axis=0) - corners
    edge = np.sqrt(np.einsum("imj,imj->im", ways, ways))
    owner, weights, share = _split(ways, edge, longest)
    return Sampler(
        faces=faces,
        count=len(points),
        fine=np.flatnonzero(~large).astype(np.int32),
        split_face=np.flatnonzero(large)[owner],
        split_weights=weights,
        split_share=share,
    )


def _split(ways: FloatArray, edge: FloatArray, longest: float) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return face (q,), barycentric centroid (q, 3) and share of the face's area (q,) of all pieces of m faces.

    A face is cut along the height over its longest edge, and the two right triangles into strips beside the height:
    pieces of a long face are as compact as those of others.
    ways (3, m, 3), edge (3, m): from each corner to the next, and how long.
    """
    row = np.arange(edge.shape[1])
    start = edge.argmax(axis=0)
    base, side, length = ways[start, row], -ways[(start + 2) % 3, row], edge[start, row]
    part = np.clip(np.einsum("ij,ij->i", base, side) / length**2, 0.0, 1.0)  # of the edge, up to the height
    height = np.sqrt(((side - part[:, None] * base) ** 2).sum(axis=1))
    crowding = float((length / longest + 1.0) @ (height / longest + 1.0)) / MAX_SAMPLES
    piece = longest / np.sqrt(2.0) * max(1.0, np.sqrt(crowding))
    one, other, tip = (np.eye(3)[(start + k) % 3] for k in range(3))
    foot = one + part[:, None] * (other - one)
    halves = np.concatenate([np.stack([foot, tip, end], axis=1) for end in (one, other)])
    part = np.concatenate([part, 1.0 - part])
    along = _count(part * np.tile(length, 2), piece)
    kind = along * (MAX_SPLIT + 1) + np.tile(_count(height, piece), 2)
    order = np.argsort(kind, kind="stable")
    order = order[part[order] > 0.0]
    names, first = np.unique(kind[order], return_index=True)
    owners, weights, shares = [row[:0]], [np.zeros((0, 3))], [np.zeros(0)]
    for name, alike in zip(names, np.split(order, first[1:]), strict=False):
        pattern, share = _strips(*divmod(int(name), MAX_SPLIT + 1))
        owners.append(np.repeat(alike % len(row), len(share)))
        weights.append(np.einsum("qk,hkc->hqc", pattern, halves[alike]).reshape(-1, 3))
        shares.append(np.outer(part[alike], share).ravel())
    return np.concatenate(owners), np.concatenate(weights), np.concatenate(shares)


def _count(size: FloatArray, piece: float) -> IntArray:
    return np.asarray(np.clip(np.ceil(size / piece), 1, MAX_SPLIT), np.int64)


@lru_cache(maxsize=MAX_SPLIT)
def _strips(along: int, across: int) -> tuple[FloatArray, FloatArray]:
    """Cut a triangle into `along` strips beside its first edge, the first of them into `across` pieces.

    Strips get shorter towards the third corner, and are cut into fewer pieces, all equal.
    Returns (q, 3) the pieces' centroids, barycentric, and (q,) their shares of the area.
    """
    near = 1.0 - np.arange(along) / along  # length of each strip's two sides, over the edge's
    far = near - 1.0 / along
    count = np.ceil(across * near - ROUNDING).astype(np.int64)
    strip = np.repeat(np.arange(along), count)
    place = (np.arange(len(strip)) - (np.cumsum(count) - count)[strip] + 0.5) / count[strip]
    level = (2.0 / 3.0 * (near**3 - far**3) / (near**2 - far**2))[strip]  # of the centroid, 1 at the edge
    share = ((near**2 - far**2) / count)[strip]
    return np.column_stack([level * (1.0 - place), level * place, 1.0 - level]), share
