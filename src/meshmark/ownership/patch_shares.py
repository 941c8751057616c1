"""What is seen at a cell of the patches around it, by which it is judged how visible a change is there."""

from __future__ import annotations

from typing import Final

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells

__all__ = ["patch_shares"]

# A cell is judged by the patches around it, a Gaussian of this width in spacings.
PATCH_WIDTH: Final = 0.5
# Shares below this are none: products with numbers next to 0 take many times as long.
LEAST_SHARE: Final = 1e-100


def patch_shares(cells: Cells, centres: FloatArray, normals: FloatArray) -> FloatArray:
    """Return the share (n, k) of each patch in what is seen at each cell; rows sum to 1.

    Parameters
    ----------
    cells : Cells
        n of them.
    centres, normals : (k, 3) float arrays
        Of the patches, in lattice coordinates, and unit vectors.
    """
    places = cells.nodes + cells.offset[:, None] * cells.normal
    apart = ((places[:, None, :] - centres) ** 2).sum(axis=2)
    facing = np.maximum(cells.normal @ normals.T, 0.0)
    weight = np.exp(-0.5 * apart / PATCH_WIDTH**2) * facing + np.finfo(float).tiny
    shares = weight / weight.sum(axis=1, keepdims=True)
    return np.where(shares < LEAST_SHARE, 0.0, shares)
