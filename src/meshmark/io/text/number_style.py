"""How a text file writes its numbers, so that new ones can be written in the same manner."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from meshmark.io.text.numbers import ByteArray
from meshmark.mesh import FloatArray, IntArray

__all__ = ["ALL_DIGITS", "NumberStyle", "detect_style", "digits_needed", "magnitude"]

Kind = Literal["fixed", "positional", "general", "exponent", "shortest", "whole"]

# Digits beyond these carry nothing: 17 significant ones tell any two doubles apart.
ALL_DIGITS = 17
# New coordinates are resolved to this share of the bounding-box diagonal.
_RESOLUTION = 1e-7
_DOT = ord(".")


@dataclass(frozen=True, kw_only=True)
class NumberStyle:
    """The manner in which a file writes numbers.

    kind:        fixed: always the same number of decimals (`%.6f`); positional: as many as needed, never
                 an exponent; general: an exponent for very small and large ones (`%g`); exponent: always
                 one (`%e`); shortest: as few digits as tell the double (`repr`); whole: no decimals.
    significant: most significant digits found. decimals, least: most and fewest decimals found, of the
                 mantissa for kind exponent.
    exponents:   whether the file writes any; upper: whether they are written `E`.
    """

    kind: Kind
    significant: int
    decimals: int
    least: int
    exponents: bool = False
    upper: bool = False

    def describe(self) -> str:
        """Return the style in words."""
        if self.kind in ("shortest", "whole"):
            return "text, full precision" if self.kind == "shortest" else "text, whole numbers"
        if self.kind in ("fixed", "exponent"):
            return f"text, {self.decimals} decimals" + " and an exponent" * (self.kind == "exponent")
        return f"text, {self.significant} significant digits"


def detect_style(text: ByteArray, starts: IntArray, ends: IntArray, values: FloatArray) -> NumberStyle:
    """Return the style of the numbers in the spans, ascending; values: (k,) what they say."""
    region = text[starts[0] : ends[-1]]
    powers, owner = _inside(starts, ends, np.flatnonzero((region | 0x20) == ord("e")) + starts[0])
    dots, owner_of_dot = _inside(starts, ends, np.flatnonzero(region == _DOT) + starts[0])
    mantissa_ends = ends.copy()
    mantissa_ends[owner] = powers
    decimals = np.zeros(len(starts), dtype=np.int64)
    decimals[owner_of_dot] = mantissa_ends[owner_of_dot] - dots - 1
    plain = np.ones(len(starts), dtype=bool)
    plain[owner] = False
    significant = max(
        _significant(decimals[plain], values[plain]), int((decimals[~plain] + 1).max(initial=0))
    )
    most, least = int(decimals.max()), int(decimals.min())
    kind: Kind = "general" if len(powers) else "positional"
    if len(powers) == len(starts):
        kind = "exponent"
    elif kind == "positional" and most == least > 0:
        kind = "fixed"
    elif significant >= ALL_DIGITS - 1:
        kind = "shortest"
    upper = bool((text[powers] == ord("E")).any())
    return NumberStyle(
        kind=kind,
        significant=max(significant, 1),
        decimals=most,
        least=least,
        exponents=bool(len(powers)),
        upper=upper,
    )


def _inside(starts: IntArray, ends: IntArray, places: IntArray) -> tuple[IntArray, IntArray]:
    """Return the places that lie in a span, and the span of each."""
    owner = np.searchsorted(starts, places, side="right") - 1
    within = places < ends[owner]
    return places[within], owner[within]


def _significant(decimals: IntArray, values: FloatArray) -> int:
    size = np.abs(values)
    return int((decimals + magnitude(size) + 1)[size > 0].max(initial=0))


def magnitude(size: FloatArray) -> IntArray:
    """Return the (k,) powers of ten at or below these sizes; 0 for 0."""
    return np.floor(np.log10(np.where(size > 0, size, 1.0))).astype(np.int64)


def digits_needed(style: NumberStyle, vertices: FloatArray, resolution: float = _RESOLUTION) -> int:
    """Return the digits with which `style` writes these (n, 3) positions.

    They resolve `resolution` times the bounding-box diagonal and are never fewer than the file's
    own: decimals for kinds fixed and positional, decimals of the mantissa for exponent, significant
    digits for general.
    """
    own = {"general": style.significant, "positional": style.least}.get(style.kind, style.decimals)
    own = min(own, ALL_DIGITS) if style.kind == "exponent" else own
    with np.errstate(over="ignore"):
        diagonal = math.hypot(*(vertices.max(axis=0) - vertices.min(axis=0)).tolist())
    if style.kind in ("shortest", "whole") or not 0 < resolution * diagonal < math.inf:
        return own
    largest = int(magnitude(np.abs(vertices).max(keepdims=True))[0, 0])
    decimals = min(math.ceil(-math.log10(resolution * diagonal)), ALL_DIGITS - 1 - largest)
    if style.kind in ("fixed", "positional"):
        return max(own, decimals)
    return max(own, largest + decimals + (style.kind == "general"))
