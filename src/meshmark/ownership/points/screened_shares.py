"""How well the coordinates of one mode lock, all shares at once, to choose those that are looked at again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.points.lock_chance import log10_loose_chance

__all__ = ["ScreenedShares"]


@dataclass(frozen=True, eq=False, kw_only=True)
class ScreenedShares:
    """The n coordinates that carry, in the order of their draws, of m that were given.

    rows: (n,) which of the m they are. group: (n,) coordinates of one group, of which the key says the same; groups
    are numbered in the order of their draws. ends: (k,) the last group of each share that has coordinates enough.
    """

    rows: IntArray
    group: IntArray
    ends: IntArray

    @classmethod
    def of(
        cls,
        carries: NDArray[np.bool_],
        draw: FloatArray,
        group: IntArray,
        cuts: Sequence[float],
        readable: int,
    ) -> ScreenedShares:
        """Return those that carry (m,), of coordinates with these draws (m,), rising, and groups (m,), any numbers.

        cuts: the draw below which each share carries, falling; those that leave fewer than `readable` have no end.
        """
        rows = np.flatnonzero(carries)
        names = group[rows]
        place = np.arange(len(rows))
        first = np.empty(int(names.max(initial=-1)) + 1, np.int64)
        first[names[::-1]] = place[::-1]  # where each group comes first: of several values the last one stays
        starts = np.flatnonzero(first[names] == place)
        number = np.empty_like(first)
        number[names[starts]] = np.arange(len(starts))
        count = np.cumsum(np.bincount(number[names], minlength=len(starts)))
        ends = np.searchsorted(draw[rows][starts], cuts) - 1
        enough = [end >= 0 and count[end] >= readable for end in ends]
        return cls(rows=rows, group=number[names], ends=ends[np.logical_and.accumulate(enough)])

    def log10_chances(self, cosine: NDArray[np.floating], sine: NDArray[np.floating]) -> list[float]:
        """Return the loose chance of the lock of each share that has an end, of all coordinates' waves (m,)."""
        if not len(self.ends):
            return []
        real = np.bincount(self.group, cosine.take(self.rows)).astype(np.float64)
        imaginary = np.bincount(self.group, sine.take(self.rows)).astype(np.float64)
        scores = np.cumsum(real)[self.ends].tolist()
        squares = np.cumsum(real**2 + imaginary**2)[self.ends].tolist()
        return [log10_loose_chance(*each) for each in zip(scores, squares, strict=True)]
