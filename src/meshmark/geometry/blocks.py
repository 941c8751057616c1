"""Long arrays in pieces whose temporaries stay in the processor's cache."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from numpy.typing import NDArray

__all__ = ["LARGE", "append", "blocks"]

BLOCK = 1 << 15
LARGE = 1 << 21
"""A size of blocks for sums that depend, in their last bits, on how they are split: most models are one block."""


def blocks(count: int, size: int = BLOCK) -> Iterator[slice]:
    """Yield slices that cover `count` rows, `size` at a time."""
    for start in range(0, count, size):
        yield slice(start, min(start + size, count))


def append(whole: NDArray[Any], part: NDArray[Any]) -> None:
    """Make an array that nobody else looks at longer by the rows of another, in place.

    Where a long one does not fit, the system moves its pages: never are there two of it.
    """
    before = len(whole)
    whole.resize((before + len(part), *whole.shape[1:]), refcheck=False)
    whole[before:] = part
