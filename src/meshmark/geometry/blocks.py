"""Long arrays in pieces whose temporaries stay in the processor's cache."""

from __future__ import annotations

from collections.abc import Iterator

__all__ = ["LARGE", "blocks"]

BLOCK = 1 << 15
LARGE = 1 << 21
"""A size of blocks for sums that depend, in their last bits, on how they are split: most models are one block."""


def blocks(count: int, size: int = BLOCK) -> Iterator[slice]:
    """Yield slices that cover `count` rows, `size` at a time."""
    for start in range(0, count, size):
        yield slice(start, min(start + size, count))
