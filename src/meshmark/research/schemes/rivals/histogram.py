"""Vertex norms in equal bins, each bin holding one bit by the mean or the variance of its norms (Cho et al. 2007).

The distances rho of points from a centre are cut into N bins of equal width between the least and the largest. In a
bin they are mapped to [0, 1] by the bin's own least and largest, which stay where they are: the bins stay, too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from meshmark.mesh import FloatArray, IntArray
from meshmark.research.schemes.scheme import Bits

__all__ = ["MEAN", "VARIANCE", "Bins", "Statistic", "bins_of", "raised", "within"]

# Exponents are multiples of this, as in the paper.
STEP = 0.001
LARGEST = 40_000  # of steps
FEWEST = 3
"""A bin with fewer points carries nothing: its least and its largest do not move."""


@dataclass(frozen=True, kw_only=True)
class Statistic:
    """What of the mapped norms x in [0, 1] holds a bit: above `middle` is 1.

    value: of the numbers in a bin, their mean is the statistic; power: x and an exponent k -> the moved x; the
    statistic falls as k grows.
    """

    middle: float
    value: Callable[[FloatArray], FloatArray]
    power: Callable[[FloatArray, FloatArray], FloatArray]


def _from_centre(x: FloatArray, k: FloatArray) -> FloatArray:
    arm = 2.0 * x - 1.0
    return np.asarray(0.5 + 0.5 * np.sign(arm) * np.abs(arm) ** k)


MEAN = Statistic(middle=1 / 2, value=lambda x: x, power=lambda x, k: np.asarray(x**k))
VARIANCE = Statistic(middle=1 / 3, value=lambda x: np.asarray((2.0 * x - 1.0) ** 2), power=_from_centre)


@dataclass(frozen=True, eq=False, kw_only=True)
class Bins:
    """Norms (n,) mapped into their bins: bin (n,), x (n,) in [0, 1], and of each bin (N,) count, low and width."""

    bin: IntArray
    x: FloatArray
    count: IntArray
    low: FloatArray
    width: FloatArray

    @property
    def carries(self) -> FloatArray:
        """(N,): 1.0 for bins that can carry a bit."""
        return ((self.count >= FEWEST) & (self.width > 0.0)).astype(float)

    def margins(self, statistic: Statistic) -> FloatArray:
        """Return (N,): the statistic of each bin minus its middle, 0 where it carries nothing."""
        return self.carries * (self.mean(statistic.value(self.x)) - statistic.middle)

    def mean(self, values: FloatArray) -> FloatArray:
        """Return (N,): the mean of `values` (n,) in each bin, 0 in an empty one."""
        return np.bincount(self.bin, values, len(self.count)) / np.maximum(self.count, 1)

    def norms(self, x: FloatArray) -> FloatArray:
        """Return (n,): the norms for mapped ones."""
        return self.low[self.bin] + x * self.width[self.bin]


def bins_of(norms: FloatArray, count: int) -> Bins:
    """Return the norms (n,), at least one, in `count` bins of equal width from their least to their largest."""
    least, largest = float(norms.min()), float(norms.max())
    span = (largest - least) or 1.0
    at = np.minimum((count * ((norms - least) / span)).astype(np.int64), count - 1)
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, at, norms)
    np.maximum.at(high, at, norms)
    sizes = np.bincount(at, minlength=count)
    low, width = np.where(sizes > 0, low, 0.0), np.where(sizes > 0, high - low, 0.0)
    x = (norms - low[at]) / np.where(width > 0.0, width, 1.0)[at]
    return Bins(bin=at, x=np.clip(x, 0.0, 1.0), count=sizes, low=low, width=width)


def within(norms: FloatArray, trim: float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return (n,): norms that remain when a share `trim` is left out at either end.

    The limits are norms of points, which `raised` leaves where they are, and no point overtakes another: the same
    points remain afterwards.
    """
    ends = int(trim * len(norms))
    least, largest = np.partition(norms, (ends, len(norms) - 1 - ends))[[ends, len(norms) - 1 - ends]]
    return np.asarray((norms >= least) & (norms <= largest))


def raised(bins: Bins, code: Bits, statistic: Statistic, margin: float) -> FloatArray:
    """Return the norms (n,) after each bin was moved until its statistic is `margin` beyond the middle.

    code: (N,). The exponent is the multiple of 0.001 nearest to 1 that reaches it, found by halving instead of by
    steps; a bin that cannot reach it is moved as far as the largest exponent goes.
    """
    goal = statistic.middle + margin * np.where(code == 1, 1.0, -1.0)

    def reached(steps: IntArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        value = bins.mean(statistic.value(statistic.power(bins.x, _exponent(steps, code)[bins.bin])))
        return np.where(code == 1, value >= goal, value <= goal)

    few, many = np.zeros(len(code), np.int64), np.where(code == 1, round(1 / STEP) - 1, LARGEST)
    while (few < many).any():
        middle = (few + many) // 2
        enough = reached(middle)
        few, many = np.where(enough, few, np.minimum(middle + 1, many)), np.where(enough, middle, many)
    exponent = np.where(bins.carries > 0.0, _exponent(few, code), 1.0)
    return bins.norms(statistic.power(bins.x, exponent[bins.bin]))


def _exponent(steps: IntArray, code: Bits) -> FloatArray:
    """Return exponents this number of steps below 1 for bit 1, above 1 for bit 0."""
    return np.where(code == 1, 1.0 - STEP * steps, 1.0 + STEP * steps)
