"""All whole-numbered places in many boxes, some boxes at a time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from meshmark.arrays import members
from meshmark.mesh import FloatArray, IntArray

__all__ = ["places_in_boxes"]


def places_in_boxes(low: FloatArray, high: FloatArray, most: int) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield box numbers (q,) and places (d, q) in boxes from `low` to `high` (t, d), about `most` at a time."""
    first = np.ceil(low).astype(np.int64)
    size = np.floor(high).astype(np.int64) - first + 1
    ends = np.cumsum(size.prod(axis=1))
    start = 0
    while start < len(ends):
        before = ends[start - 1] if start else 0
        stop = max(int(np.searchsorted(ends, before + most)), start + 1)
        counts = np.diff(ends[start:stop], prepend=before)
        box, rest = members(counts)
        box += start
        place = first[box].T
        for axis in reversed(range(1, size.shape[1])):
            rest, along = np.divmod(rest, size[box, axis])
            place[axis] += along
        place[0] += rest
        yield box, place
        start = stop
