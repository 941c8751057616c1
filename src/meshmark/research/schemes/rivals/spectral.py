"""Spread spectrum on the lowest frequencies of the mesh (Ohbuchi et al. 2002)."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from hashlib import blake2b

import numpy as np
from scipy.sparse import csc_array, diags_array

from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.mesh import FloatArray
from meshmark.research.schemes.rivals.codeword import chips, votes
from meshmark.research.schemes.rivals.eigen import smallest_eigenpairs
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.rival import Informed
from meshmark.research.schemes.scheme import Bits

__all__ = ["Spectral"]

# Where much of a model is lost, frequencies of which less than this is left are damped.
LEAST = 0.05
# Bases of the last few originals: reading many suspects of one original needs its basis once.
_BASES: OrderedDict[bytes, FloatArray] = OrderedDict()
_KEPT = 3


@dataclass(frozen=True)
class Spectral(Informed):
    """Coordinates on the first eigenvectors of the graph's Laplacian, each moved up or down by the same amount.

    vectors: number of eigenvectors; each has three coefficients, x, y and z. A code bit has a keyed share of them.
    """

    title = "Spectral, informed"
    source = "Ohbuchi, Mukaiyama, Takahashi 2002, doi:10.1111/1467-8659.t01-1-00597; Cayre et al. 2003"
    reconstruction = (
        "one basis for the whole model instead of patches; registration, pilots and amplitude are ours"
    )
    pilots: int = 32
    vectors: int = 96

    def _placed(self, host: Host, code: Bits, key: Key, budget: float) -> FloatArray:
        basis = self._basis(host)
        bit, sign = chips(key, "spectral", 3 * basis.shape[1], self._length)
        pattern = sign * (1.0 - 2.0 * code[bit])
        moves = basis @ pattern.reshape(-1, 3)
        return host.points + moves * (0.99 * budget / host.rms(host.points + moves))

    def _compared(self, original: Host, moved: FloatArray, weights: FloatArray, key: Key) -> FloatArray:
        basis = self._basis(original)
        bit, sign = chips(key, "spectral", 3 * basis.shape[1], self._length)
        return votes(bit, sign * _fitted(basis, moved, weights).ravel(), self._length)

    def _basis(self, host: Host) -> FloatArray:
        """Return the eigenvectors (p, k) without the constant one."""
        count = min(self.vectors, len(host.points) // 2 - 1)
        if 3 * count < self._length:
            raise CapacityError(
                f"the model has {len(host.points)} points, {self.title} needs at least {2 * self._length // 3 + 4}"
            )
        name = blake2b(host.faces.tobytes() + count.to_bytes(4, "little")).digest()
        if name not in _BASES:
            degree = diags_array(np.asarray(host.graph.sum(axis=1)))
            mass = np.full(len(host.points), 1.0 / len(host.points))
            vectors = smallest_eigenpairs(csc_array(degree - host.graph), mass, count + 1)[1]
            _BASES[name] = vectors[:, 1:] / np.sqrt(len(host.points))
            while len(_BASES) > _KEPT:
                _BASES.popitem(last=False)
        return _BASES[name]


def _fitted(basis: FloatArray, moved: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the coefficients (k, 3) of a field (p, 3) known by weights (p,); what these do not tell is small."""
    seen = basis.T @ (weights[:, None] * basis) + LEAST * np.eye(basis.shape[1])
    return np.asarray(np.linalg.solve(seen, basis.T @ (weights[:, None] * moved)), np.float64)
