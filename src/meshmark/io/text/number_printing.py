"""Numbers as text in a given style, and the doubles that such text says; numpy does the bulk of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.io.text.number_style import NumberStyle, magnitude
from meshmark.io.text.numbers import ByteArray
from meshmark.mesh import FloatArray, IntArray

__all__ = ["format_numbers", "round_numbers"]

# Powers of ten that a double holds exactly.
_TENS = 10.0 ** np.arange(23)
# Below this a double counts units exactly, with room for the rounding of one product.
_EXACT = 2.0**50
# `%g` writes numbers below this with an exponent.
_SMALL = 1e-4
_DOT, _MINUS, _ZERO = b".-0"


def round_numbers(style: NumberStyle, digits: int, values: FloatArray) -> FloatArray:
    """Return the (k,) doubles that a reader gets when `values` are written with `digits`; no -0."""
    rounded = values + 0.0
    if style.kind == "shortest":
        return rounded
    places = _places(style, digits, values)
    easy = _countable(places, values)
    # A whole number over an exact power of ten is one division: rounded as a correct reader rounds.
    tens = _TENS[places[easy]]
    rounded[easy] = np.rint(values[easy] * tens) / tens
    if not easy.all():
        rounded[~easy] = [float(word) for word in _words(style, digits, values[~easy], places[~easy])]
    return rounded + 0.0


def format_numbers(style: NumberStyle, digits: int, values: FloatArray) -> tuple[ByteArray, IntArray]:
    """Return the texts of the (k,) numbers, one after the other, and their lengths.

    `values` come from `round_numbers` with the same style and digits, and read back exactly.
    """
    places = _places(style, digits, values)
    easy = _countable(places, values)
    hard = _words(style, digits, values[~easy], places[~easy])
    sizes = np.array(list(map(len, hard)), dtype=np.int64)
    if not easy.any():
        return np.frombuffer("".join(hard).encode("ascii"), dtype=np.uint8), sizes
    figures = int(places[easy].max(initial=0)) + 1 + len(str(int(np.abs(values[easy]).max(initial=0))))
    width = max(figures + 2, int(sizes.max(initial=0)))
    cells = np.full((len(values), width), _ZERO, dtype=np.uint8)
    begins, ends = np.empty(len(values), dtype=np.int64), np.full(len(values), width)
    for decimals in np.flatnonzero(np.bincount(places[easy])).tolist():
        rows = np.flatnonzero(easy & (places == decimals))
        units = np.rint(values[rows] * _TENS[decimals]).astype(np.int64)
        cells[rows], begins[rows] = _print_units(units, decimals, width)
        if style.kind != "fixed":
            ends[rows] -= _spare_zeros(cells[rows], decimals, style.least)
    if hard:
        cells[~easy] = np.array(hard, dtype=f"S{width}").view(np.uint8).reshape(-1, width)
        begins[~easy], ends[~easy] = 0, sizes
    column = np.arange(width)
    return cells[(column >= begins[:, None]) & (column < ends[:, None])], ends - begins


def _places(style: NumberStyle, digits: int, values: FloatArray) -> IntArray:
    """Return the decimals of each number in positional notation; -1 where it is written otherwise."""
    if style.kind in ("fixed", "whole"):
        return np.full(len(values), digits, dtype=np.int64)
    size = np.abs(values)
    below = magnitude(size)
    if style.kind == "positional":
        return np.maximum(digits, np.minimum(style.significant - 1 - below, style.decimals))
    plain = (style.kind == "general") & (below < digits) & ((size >= _SMALL) | (size == 0))
    return np.where(plain, digits - 1 - below, -1)


def _countable(places: IntArray, values: FloatArray) -> NDArray[np.bool_]:
    """Return which numbers are a count of units of a decimal place, without exponent, in 50 bits."""
    size = np.abs(values)
    fits = (places >= 0) & (places < len(_TENS)) & (size < _EXACT)
    return np.asarray(fits & (np.where(fits, size, 0) * _TENS[np.where(fits, places, 0)] < _EXACT))


def _words(style: NumberStyle, digits: int, values: FloatArray, places: IntArray) -> list[str]:
    pairs = zip(values.tolist(), places.tolist(), strict=True)
    if style.kind == "shortest":
        words = [repr(value) for value, _ in pairs]
        if not style.exponents:
            words = [
                np.format_float_positional(float(word), trim="0") if "e" in word else word for word in words
            ]
    elif style.kind in ("fixed", "positional", "whole"):
        words = [f"{value:.{max(place, 0)}f}" for value, place in pairs]
    else:
        words = [f"{value:.{digits}{'g' if style.kind == 'general' else 'e'}}" for value, _ in pairs]
    return [word.upper() for word in words] if style.upper else words


def _print_units(units: NDArray[np.int64], decimals: int, width: int) -> tuple[ByteArray, IntArray]:
    """Return right-aligned rows that say units * 10^-decimals, and the column where each begins."""
    rest = np.abs(units)
    figures = max(decimals + 1, len(str(int(rest.max()))))
    cells = np.full((len(units), width), _ZERO, dtype=np.uint8)
    begins = np.full(len(units), width - 1 - decimals - (decimals > 0), dtype=np.int64)
    column = width - 1
    for place in range(figures):
        if place == decimals > 0:
            cells[:, column] = _DOT
            column -= 1
        if place > decimals:
            begins -= rest > 0
        rest, digit = np.divmod(rest, 10)
        cells[:, column] += digit.astype(np.uint8)
        column -= 1
    negative = units < 0
    begins -= negative
    cells[negative, begins[negative]] = _MINUS
    return cells, begins


def _spare_zeros(cells: ByteArray, decimals: int, least: int) -> IntArray:
    """Return how many final characters of each row say nothing: zeros beyond `least`, and a bare dot."""
    spare = np.zeros(len(cells), dtype=np.int64)
    going = np.ones(len(cells), dtype=bool)
    for place in range(decimals - least):
        going &= cells[:, -1 - place] == _ZERO
        spare += going
    if least == 0 and decimals:
        spare += spare == decimals
    return spare
