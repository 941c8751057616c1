"""Lines of numbers for fresh text files, in full precision."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import IntArray

__all__ = ["index_lines", "number_lines"]


def number_lines(head: str, columns: Sequence[NDArray[Any]]) -> str:
    """Return one line per row of the (n, k) arrays, side by side, in the shortest digits that tell them."""
    words = [list(map(repr, column.ravel().tolist())) for column in columns]
    width = [column.shape[1] for column in columns]
    lanes = [part[k::size] for part, size in zip(words, width, strict=True) for k in range(size)]
    return "".join([f"{head}{' '.join(row)}\n" for row in zip(*lanes, strict=True)])


def index_lines(head: str, groups: Sequence[IntArray], base: int, joint: str = "/") -> str:
    """Return one line per row of the (m, 3) indices, those of several groups joined at each corner."""
    if not len(groups[0]):
        return ""
    corner = joint.join(["%d"] * len(groups))
    line = f"{head}{corner} {corner} {corner}\n"
    numbers = np.stack([group + base for group in groups], axis=2).ravel().tolist()
    return line * len(groups[0]) % tuple(numbers)
