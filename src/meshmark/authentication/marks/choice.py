"""Which points carry marks: an independent set, of points whose marks are firm and whose rings are unlike first."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.marks.candidates import HEADER, Candidates
from meshmark.authentication.marks.independent_points import independent_points
from meshmark.authentication.marks.ring_shapes import RingShapes
from meshmark.authentication.marks.rings import Rings
from meshmark.geometry.connectivity import Connectivity
from meshmark.mesh import FloatArray, IntArray

__all__ = ["alike", "completed", "firm_first", "firm_points"]


def firm_points(points: FloatArray, parts: Iterable[tuple[Rings, RingShapes]]) -> NDArray[np.bool_]:
    """Return (p,): the points that do not lie so far from the middle of a needle ring that its turning moves them.

    Such carry marks only where no other can. What else an error does to a mark's place depends on the ring alone
    (`RingShapes.spread`).
    """
    firm = np.ones(len(points), bool)
    for group, shape in parts:
        far = np.linalg.norm(points[group.vertex] - shape.centre, axis=1)
        firm[group.vertex] = far * shape.sway <= shape.style.firm * shape.spread * shape.size
    return firm


def firm_first(
    connectivity: Connectivity, allowed: NDArray[np.bool_], firm: NDArray[np.bool_], chance: FloatArray
) -> NDArray[np.bool_]:
    """Return (p,): a maximal set of `allowed` (p,) points without neighbours in it, `firm` (p,) ones first."""
    chosen = independent_points(connectivity.edges, allowed & firm, chance)
    if (allowed & ~firm).any():
        chosen = completed(connectivity, chosen, allowed, allowed, chance)
    return chosen


def completed(
    connectivity: Connectivity,
    chosen: NDArray[np.bool_],
    allowed: NDArray[np.bool_],
    first: NDArray[np.bool_],
    chance: FloatArray,
) -> NDArray[np.bool_]:
    """Return (p,): the `chosen` points, which are no neighbours, and more until the set is maximal.

    Those of the `allowed` (p,) that are among the `first` (p,) come before the others.
    """
    for some in (first, allowed):
        free = allowed & some & ~chosen
        free[free] = ~((connectivity.graph @ chosen.astype(np.float64))[free] > 0.0)
        if free.any():
            chosen = chosen | independent_points(connectivity.edges, free, chance)
    return chosen


def alike(found: Candidates, kept: NDArray[np.bool_] | None = None) -> IntArray:
    """Return the points of marks that tell the id whose rings are those of another one, but for one of each.

    kept: (p,) points of which that one is, if it can be.
    """
    header = found.take(found.kind == HEADER)
    if kept is not None:
        header = header.take(np.argsort(~kept[header.vertex], kind="stable"))
    first = np.unique(header.name, return_index=True)[1]
    return np.delete(header.vertex, first)
