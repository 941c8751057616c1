"""Which cells carry: enough surface in the window, flat enough, and not off to a side."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import IntArray
from meshmark.ownership.carriers.cells import Cells

__all__ = ["select_cells"]


def select_cells(cells: Cells, limits: tuple[float, float, float]) -> IntArray:
    """Return the indices of the cells within (least mass, least flatness, largest |offset|).

    The bound on the offset keeps one of two nodes stacked along the normal, which would see the same patch.
    """
    mass, flatness, offset = limits
    chosen = (cells.mass > mass) & (cells.flatness > flatness) & (np.abs(cells.offset) < offset)
    return np.flatnonzero(chosen)
