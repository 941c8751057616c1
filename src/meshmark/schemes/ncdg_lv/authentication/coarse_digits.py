"""What a file's coordinates were rounded to, as the coordinates themselves show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from meshmark.mesh import FloatArray

__all__ = ["CoarseDigits", "coarse_digits"]

_BITS: Final = range(6, 21)
_DECIMALS: Final = range(9)
_DIGITS: Final = range(3, 8)
# A coordinate on a grid may be off it by this share of a step, as a later save in fewer digits leaves it; 32-bit
# floats are off by so many times a coordinate's size.
_OFF, _FLOATS = 0.1, 1.2e-7
# Fewer different coordinates lie on some grid by chance.
_LEAST: Final = 40


@dataclass(frozen=True)
class CoarseDigits:
    """called: such as "a grid of 16 bits"; half: the most by which it moved a coordinate, in scene units."""

    called: str
    half: float


def coarse_digits(vertices: FloatArray) -> CoarseDigits | None:
    """Return the coarsest rounding that all coordinates (n, 3) show; None where they show none.

    Decimals and significant digits of the scene's units, and grids of 6 to 20 bits over the box: of each axis or of
    the longest side. A model that was turned since it was rounded shows none.
    """
    if len(np.unique(vertices)) < _LEAST:
        return None
    found = [each for each in (_decimals(vertices), _digits(vertices), _grid(vertices)) if each is not None]
    return max(found, key=lambda each: each.half, default=None)


def _decimals(vertices: FloatArray) -> CoarseDigits | None:
    for count in _DECIMALS:
        step = 10.0**-count
        if _on(vertices, step, np.abs(vertices).max()):
            name = f"{count} decimal{'' if count == 1 else 's'}" if count else "whole numbers"
            return CoarseDigits(name, step / 2.0)
    return None


def _digits(vertices: FloatArray) -> CoarseDigits | None:
    size = np.maximum(np.abs(vertices), np.finfo(float).tiny)
    for count in _DIGITS:
        step = 10.0 ** (np.floor(np.log10(size)) - count + 1.0)
        if np.all(np.abs(vertices / step - np.rint(vertices / step)) * step <= _FLOATS * size + 1e-3 * step):
            return CoarseDigits(f"{count} significant digits", float(step.max()) / 2.0)
    return None


def _grid(vertices: FloatArray) -> CoarseDigits | None:
    low, box = vertices.min(axis=0), np.ptp(vertices, axis=0)
    largest = float(np.abs(vertices).max())
    for bits in _BITS:
        for sides in (box, np.full(3, box.max())):
            for steps in (2.0**bits - 1.0, 2.0**bits):
                step = sides / steps
                if all(_on((vertices - low)[:, k], step[k], largest) for k in range(3) if box[k] > 0.0):
                    return CoarseDigits(f"a grid of {bits} bits", float(step.max()) / 2.0)
    return None


def _on(values: FloatArray, step: float, largest: float) -> bool:
    """Return whether all values are whole numbers of steps, but for the precision of floats."""
    allowed = _FLOATS * largest / step
    if allowed > _OFF:  # finer than the floats can show
        return False
    values = values / step
    return bool(np.abs(values - np.rint(values)).max() <= _OFF)
