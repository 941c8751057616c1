"""Salient points at the maxima of the auto diffusion function, and norms in the regions around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.adjacency import ring_maximum
from meshmark.mesh import FloatArray
from meshmark.research.schemes.rivals.eigen import surface_eigenpairs
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.regional import Regional

__all__ = ["Adf"]


@dataclass(frozen=True)
class Adf(Regional):
    """ADF_t(x) = sum of exp(-t lambda_i / lambda_1) phi_i(x)^2; its maxima over a few rings are salient.

    time: t, in units of 1 / lambda_1: small for details, large for the limbs of the model.
    """

    title = "Auto diffusion function"
    source = "Medimegh et al. 2018"
    reconstruction = (
        "parameters are ours: t, number of functions and regions, norms about a region's centroid, vote"
    )
    pairs: int = 20
    time: float = 0.3
    apart: float = 0.2

    def total(self, votes: FloatArray) -> float:
        """See `Regional.total`: a second, lower maximum does not make a tip more salient."""
        return float(votes.max())

    def votes(self, host: Host) -> FloatArray:
        """See `Regional.votes`."""
        values, functions = surface_eigenpairs(host.points, host.faces, self.pairs)
        if not len(values):
            return np.zeros(len(host.points))
        diffusion = functions**2 @ np.exp(-self.time * values / values[0])
        peak = diffusion >= ring_maximum(diffusion, host.graph, self.rings)
        return np.where(peak, diffusion, 0.0)
