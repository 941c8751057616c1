"""What a file's coordinates were rounded to, as the coordinates themselves show."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray

__all__ = ["CoarseDigits", "coarse_digits"]

_BITS: Final = range(6, 21)
_DECIMALS: Final = range(9)
_DIGITS: Final = range(3, 8)
# A coordinate on a grid may be off it by this share of a step, as a later save in fewer digits leaves it; 32-bit
# floats are off by this share of a coordinate's size.
_OFF, _FLOATS = 0.1, 1.2e-7
# glTF-Transform stretches 13 bits and a sign to 16, by which a coordinate is off its step by a quarter.
_STRETCHED: Final = 0.3
# Share of the vertices that must lie on it: the others were moved later. By chance 1 in 125 does.
_SHARE: Final = 0.5
# Of fewer vertices nothing is said.
_LEAST: Final = 40


@dataclass(frozen=True, eq=False, kw_only=True)
class CoarseDigits:
    """called: such as "a grid of 16 bits"; half: the most by which it moved a coordinate, in scene units.

    off: (n,) the vertices that do not lie on it. bits: of a grid, else None.
    """

    called: str
    half: float
    off: NDArray[np.bool_]
    bits: int | None = None


def coarse_digits(vertices: FloatArray) -> CoarseDigits | None:
    """Return the coarsest rounding that most coordinates (n, 3) show; None where they show none.

    Decimals and significant digits of the scene's units, and grids of 6 to 20 bits over the box: of each axis or of
    the longest side. A model that was turned since it was rounded shows none, nor does one whose box was changed.
    """
    if len(vertices) < _LEAST:
        return None
    found = []
    for way in (_decimals, _digits, _grids):
        for called, step, off, bits in way(vertices):
            outside = np.asarray((off > 1.0).any(axis=1))
            if outside.mean() <= 1.0 - _SHARE:
                found.append(CoarseDigits(called=called, half=step / 2.0, off=outside, bits=bits))
                break
    return max(found, key=lambda each: each.half, default=None)


_Ways = Iterator[tuple[str, float, FloatArray, int | None]]


def _decimals(vertices: FloatArray) -> _Ways:
    """Yield what decimals are called, their step, how far off it (n, 3) coordinates are, in what is allowed."""
    for count in _DECIMALS:
        step = 10.0**-count
        if (off := _off(vertices, step, np.abs(vertices))) is not None:
            yield ("whole numbers" if not count else f"{count} decimal{'s' * (count > 1)}"), step, off, None


def _digits(vertices: FloatArray) -> _Ways:
    size = np.maximum(np.abs(vertices), np.finfo(float).tiny)
    for count in _DIGITS:
        step = 10.0 ** (np.floor(np.log10(size)) - count + 1.0)
        off = np.abs(vertices / step - np.rint(vertices / step)) * step / (_FLOATS * size + 1e-3 * step)
        yield f"{count} significant digits", float(step.max()), off, None


def _grids(vertices: FloatArray) -> _Ways:
    low, box = vertices.min(axis=0), np.ptp(vertices, axis=0)
    side = np.full(3, box.max())
    for bits in _BITS:
        for sides, steps, most in (
            (box, 2.0**bits - 1.0, _OFF),
            (box, 2.0**bits, _OFF),
            (side, 2.0**bits - 1.0, _OFF),
            (side, 2.0**bits, _OFF),
            (side, 2.0**bits - 2.0, _STRETCHED),
        ):
            step = np.where(box > 0.0, sides, 1.0) / steps
            if (off := _off(vertices - low, step, np.abs(vertices), most)) is not None:
                yield f"a grid of {bits} bits", float(step.max()), off, bits


def _off(
    values: FloatArray, step: float | FloatArray, size: FloatArray, most: float = _OFF
) -> FloatArray | None:
    """Return how far values lie from whole steps, in what is allowed, `most`; None where floats are too coarse."""
    if np.max(_FLOATS * size.max() / step) > _OFF:
        return None
    values = values / step
    return np.asarray(np.abs(values - np.rint(values)) / most)
