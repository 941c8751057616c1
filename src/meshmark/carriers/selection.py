"""Which cells carry: enough surface in the window, flat enough, and not off to a side."""

from __future__ import annotations

import numpy as np

from meshmark.carriers.cells import Cells
from meshmark.mesh import IntArray

__all__ = ["find_cells", "select_cells"]


def select_cells(cells: Cells, limits: tuple[float, float, float]) -> IntArray:
    """Return the indices of the cells within (least mass, least flatness, largest |offset|).

    The bound on the offset keeps one of two nodes stacked along the normal, which would see the same patch.
    """
    mass, flatness, offset = limits
    chosen = (cells.mass > mass) & (cells.flatness > flatness) & (np.abs(cells.offset) < offset)
    return np.flatnonzero(chosen)


def find_cells(cells: Cells, nodes: IntArray) -> IntArray:
    """Return where in `cells` the integer coordinates `nodes` (n, 3) are; -1 for those no longer touched."""
    low = np.minimum(cells.nodes.min(axis=0), nodes.min(axis=0))
    sizes = np.maximum(cells.nodes.max(axis=0), nodes.max(axis=0)) - low + 1
    known, wanted = (
        (part - low) @ np.array([sizes[1] * sizes[2], sizes[2], 1]) for part in (cells.nodes, nodes)
    )
    order = np.argsort(known)
    place = np.minimum(np.searchsorted(known, wanted, sorter=order), len(known) - 1)
    found = order[place]
    return np.where(known[found] == wanted, found, -1)
