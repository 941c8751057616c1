"""Types of the arrays that everything works on, and what numpy does faster in another way than the plainest."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

__all__ = ["AnyIntArray", "FloatArray", "IntArray", "members", "rows_of", "sorted_distinct"]

_Scalar = TypeVar("_Scalar", bound=np.generic)
_Integer = TypeVar("_Integer", bound=np.integer[Any])

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
AnyIntArray = NDArray[np.signedinteger[Any]]
"""Of as few bits as the numbers need, where a model has many of them."""


def rows_of(values: NDArray[_Scalar], rows: AnyIntArray | NDArray[np.bool_] | slice) -> NDArray[_Scalar]:
    """Return `values[rows]` of an array (n, ...), four times as fast where the rows are chosen one by one."""
    if isinstance(rows, slice):
        return values[rows]
    return values.take(np.flatnonzero(rows) if rows.dtype == np.bool_ else rows, axis=0)


def sorted_distinct(values: NDArray[_Integer]) -> NDArray[_Integer]:
    """Return the different ones of some integers (n,), sorted.

    As `np.unique` does by a table of hashes, which takes up to fifty times as long.
    """
    values = np.sort(values, axis=None)
    first = np.ones(len(values), bool)
    np.not_equal(values[1:], values[:-1], out=first[1:])
    return values[first]


def members(counts: IntArray) -> tuple[IntArray, IntArray]:
    """Return, for groups of the given sizes (g,) one after another, each member's group and place within it."""
    group = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(group)) - np.repeat(np.cumsum(counts) - counts, counts)
    return group, place
