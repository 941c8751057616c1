"""Salient points at the extrema of Laplace-Beltrami eigenfunctions, and norms in the regions around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.adjacency import ring_maximum
from meshmark.mesh import FloatArray
from meshmark.research.schemes.rivals.eigen import surface_eigenpairs
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.regional import Regional

__all__ = ["LaplaceBeltrami"]


@dataclass(frozen=True)
class LaplaceBeltrami(Regional):
    """Each eigenfunction votes for its extrema, for a lower one with less weight; its sign does not matter."""

    title = "Laplace-Beltrami"
    source = "detector: Niu et al.; paired with a watermark by the NCDG-LV paper"
    reconstruction = (
        "all but the idea is ours: number of functions and regions, norms about a region's centroid, vote"
    )

    def votes(self, host: Host) -> FloatArray:
        """See `Regional.votes`."""
        _, functions = surface_eigenpairs(host.points, host.faces, self.pairs)
        found = np.zeros(len(host.points))
        for function in functions.T:
            for side in (function, -function):
                peak = (side >= ring_maximum(side, host.graph, self.rings)) & (side > 0.0)
                found[peak] += side[peak] / np.abs(function).max()
        return found
