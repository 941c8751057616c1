"""How points give way to forces while what they carry stays: each by itself, or so that planes stay plane."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU, splu

from meshmark.geometry.plane_patches import PlanePatches, spreads
from meshmark.mesh import FloatArray

__all__ = ["Giving", "GivingAlone", "GivingTogether", "PlanesKept"]

# Ways to give way that yield less than this share of the most are left out.
STIFF = 1e-9
# A patch that is narrower than this share of its length is a line: it cannot tilt round itself.
LINE = 1e-7


@dataclass(frozen=True, eq=False, kw_only=True)
class PlanesKept:
    """How r points of k plane patches leave the planes of these; a point is counted in each of its patches.

    away: (r, 3p) distance of each from its plane, for a motion of all p points. slopes: (r, 3k) orthonormal, what
    of such distances is a motion of the planes themselves; 0 in the column of a tilt that a plane cannot have.
    """

    away: sp.csr_array
    slopes: sp.csr_array

    @classmethod
    def of(cls, points: FloatArray, patches: PlanePatches, joints: sp.csr_array | None) -> PlanesKept:
        """Find the planes of the patches of points (p, 3); joints: how points follow others, where some do."""
        names, patch = np.unique(patches.patch, return_inverse=True)
        count, size = len(names), np.bincount(patch)
        beside, spread = spreads(points[patches.point], patch, count)
        axes = np.linalg.eigh(spread)[1][patch]  # of each point's patch: across the plane, and two in it
        within = np.einsum("ri,rij->rj", beside, axes[:, :, 1:])
        length = np.stack([np.sqrt(np.bincount(patch, axis**2)) for axis in within.T], axis=1)
        length[length <= LINE * length.max(axis=1, keepdims=True)] = np.inf
        slopes = np.column_stack([size[patch] ** -0.5, within / length[patch]])
        away = _by_threes(axes[:, :, 0], patches.point, len(points))
        if joints is not None:
            away = away @ sp.kron(joints, sp.eye_array(3), format="csr")
        return cls(away=sp.csr_array(away), slopes=_by_threes(slopes, patch, count))


def _by_threes(values: FloatArray, block: np.ndarray, count: int) -> sp.csr_array:
    """Return (r, 3 count): values (r, 3) in the columns of the blocks (r,) of three."""
    rows = np.repeat(np.arange(len(values)), 3)
    columns = (3 * block[:, None] + np.arange(3)).ravel()
    return sp.csr_array((values.ravel(), (rows, columns)), shape=(len(values), 3 * count))


@dataclass(frozen=True, eq=False)
class GivingAlone:
    """Points that give way each by itself.

    rest: (p, 3, 3) inverse cost of the motions of each that leave what it carries as it is.
    """

    rest: FloatArray

    def given(self, forces: FloatArray) -> FloatArray:
        """Return the motions (q, 3, p) under forces (q, 3, p)."""
        motions = np.empty_like(forces)
        for force, own in zip(forces, motions, strict=True):
            for yields, axis in zip(self._yielding, own, strict=True):
                np.einsum("jp,jp->p", yields, force, out=axis)
        return motions

    def flattened(self, motion: FloatArray) -> FloatArray:
        """Return a motion (p, 3) as it is: nothing is to stay plane."""
        return motion

    @cached_property
    def _yielding(self) -> FloatArray:
        return np.ascontiguousarray(self.rest.transpose(1, 2, 0))


@dataclass(frozen=True, eq=False)
class GivingTogether:
    """Points that give way so that planes stay plane.

    rest: as of `GivingAlone`. planes: the square of a distance from these counts as much as a cost.
    The energy of ways to give way y (n,) and motions of planes c (3k,) is |y|^2 + |bends y - slopes c|^2.
    """

    rest: FloatArray
    planes: PlanesKept

    def given(self, forces: FloatArray) -> FloatArray:
        """Return the motions (q, 3, p) under forces (q, 3, p)."""
        flat = forces.transpose(2, 1, 0).reshape(-1, len(forces))
        motions = self._levers @ self._solved(self._levers.T @ flat)
        return np.ascontiguousarray(motions.reshape(-1, 3, len(forces)).transpose(2, 1, 0))

    def flattened(self, motion: FloatArray) -> FloatArray:
        """Return a motion (p, 3) with what takes points back to the planes added."""
        off = self.planes.away @ motion.ravel()
        off -= self.planes.slopes @ (self.planes.slopes.T @ off)
        further = self._levers @ self._solved(-(self._bends.T @ off)[:, None])
        return np.asarray(motion + further.reshape(motion.shape), dtype=np.float64)

    @cached_property
    def _levers(self) -> sp.csr_array:
        """(3p, n): the motions for a unit of each of the n ways to give way; `rest` is levers @ levers.T."""
        values, vectors = np.linalg.eigh(self.rest)
        least = STIFF * max(float(values.max(initial=0.0)), np.finfo(float).tiny)
        point, way = np.nonzero(values > least)
        levers = (vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :])[point, :, way]
        return sp.csr_array(_by_threes(levers, point, len(self.rest)).T)

    @cached_property
    def _bends(self) -> sp.csr_array:
        """(r, n): how far a unit of each way to give way moves points off the planes."""
        return sp.csr_array(self.planes.away @ self._levers)

    @cached_property
    def _factors(self) -> SuperLU:
        """Of the energy of y and c, (n + 3k, n + 3k)."""
        bends, slopes = self._bends, self.planes.slopes
        own = sp.eye_array(bends.shape[1]) + bends.T @ bends
        between = -(bends.T @ slopes)
        energy: Any = sp.block_array(
            [[own, between], [between.T, sp.eye_array(slopes.shape[1])]], format="csc"
        )
        # Symmetric and positive definite: no pivots are needed. Patches of many points are rows of many entries,
        # with which minimum degree orderings of the symmetric graph take quadratic time.
        return splu(energy, permc_spec="COLAMD", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def _solved(self, forces: FloatArray) -> FloatArray:
        """Return the ways (n, q) to give way under forces (n, q), while the planes follow."""
        on_planes = np.zeros((self.planes.slopes.shape[1], forces.shape[1]))
        return np.asarray(self._factors.solve(np.concatenate([forces, on_planes]))[: len(forces)])


Giving = GivingAlone | GivingTogether
