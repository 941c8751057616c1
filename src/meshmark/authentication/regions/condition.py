"""What became of each point: parts that were moved as one are told from what was changed itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.authentication.checks.checks import Checks
from meshmark.geometry.components import connected_parts
from meshmark.mesh import IntArray

__all__ = ["CONDITIONS", "conditions"]

CONDITIONS = ("intact", "altered", "moved", "cut_off", "unchecked")
"""intact: as it was signed off. altered: moved, made, or exposed by a deletion. moved: altered as well, but
its marks hold: moved as one, or pasted from elsewhere in the model, its inside intact. cut_off: its marks hold
where it lies, but what was altered parts it from the rest, with which it may have moved a little, as one.
unchecked: nothing tells."""
# Marks by which a part is known to be one: single marks hold by chance.
_MARKS = 3


def conditions(graph: csr_array, checks: Checks, altered: NDArray[np.bool_]) -> IntArray:
    """Return (p,): the condition of each point, an index into `CONDITIONS`.

    Parameters
    ----------
    graph : (p, p) sparse matrix
        The vertex graph of the suspect's surface.
    checks : Checks
    altered : (p,) bool array
        The points that the map shows as altered.
    """
    intact, changed, moved, cut_off, unchecked = range(len(CONDITIONS))
    state = np.where(altered, changed, intact)
    if not (checks.eligible | checks.verified).any():
        return np.full(len(altered), unchecked)
    elsewhere = checks.elsewhere & altered
    near = altered & (elsewhere | (graph @ elsewhere.astype(np.float64) > 0.0))
    state[near & (_marks_of_part(graph, near, elsewhere) >= _MARKS)] = moved
    state[_islands(graph, altered) & (_marks_of_part(graph, ~altered, checks.passed) >= _MARKS)] = cut_off
    return state


def _marks_of_part(graph: csr_array, there: NDArray[np.bool_], marks: NDArray[np.bool_]) -> IntArray:
    """Return (p,): how many marks lie in the connected part of each of the points that are `there`, 0 elsewhere."""
    part = connected_parts(graph, there)
    if not there.any():
        return np.zeros(len(there), np.int64)
    count = np.bincount(part[there], marks[there], int(part.max()) + 1)
    return np.where(there, count[part], 0.0).astype(np.int64)


def _islands(graph: csr_array, altered: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): points that are not altered, but parted by altered ones from more of their connected
    component."""
    whole = connected_parts(graph, np.ones(len(altered), bool))
    part = connected_parts(graph, ~altered)
    rows = np.flatnonzero(~altered)
    if not altered.any() or not len(rows):
        return np.zeros(len(altered), bool)
    size = np.bincount(part[rows], minlength=int(part.max()) + 1)
    largest = np.zeros(int(whole.max()) + 1, np.int64)
    np.maximum.at(largest, whole[rows], size[part[rows]])
    island = np.zeros(len(altered), bool)
    island[rows] = size[part[rows]] < largest[whole[rows]]
    return island
