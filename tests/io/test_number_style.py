"""New numbers in the manner of the old ones, and what a reader gets from them."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.errors import InputError
from meshmark.io.text.number_printing import format_numbers, round_numbers
from meshmark.io.text.number_style import NumberStyle, detect_style, digits_needed
from meshmark.io.text.positions import TextPositions, merge_edits, splice, text_positions
from meshmark.io.text.tokens import tokenise
from tests.counting import some

STYLES = {
    "fixed": ["0.125000", "-1.000000", "10.333333"],
    "fixed coarse": ["0.1", "-1.0", "10.3"],
    "positional": ["0.125", "-1", "10.3333"],
    "positional with a decimal": ["0.125", "-1.0", "10.3333"],
    "whole": ["0", "-1", "10"],
    "general": ["0.125", "-1e-05", "10.3333"],
    "exponent": ["1.25e-01", "-1.00e+00", "1.03e+01"],
    "exponent capital": ["1.25E-01", "-1.00E+00", "1.03E+01"],
    "shortest": ["0.1", "-1e-17", "10.333333333333334"],
    "shortest without exponents": ["0.1", "-1.0", "10.333333333333334"],
}
coordinates = (
    st.floats(-1e6, 1e6, allow_nan=False)
    | st.integers(-50, 50).map(float)
    | st.sampled_from([1e-9, -0.0, 1e-4])
)
rows = st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=1, max_size=12)


def positions(words: list[str]) -> TextPositions:
    data = " ".join(words).encode()
    tokens = tokenise(data)
    return text_positions(data, tokens.starts.reshape(-1, 3), tokens.ends.reshape(-1, 3))


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("fixed", 0.5, "0.500000"),
        ("fixed", -3.25, "-3.250000"),
        ("fixed coarse", 0.5, "0.500000"),  # 1e-7 of a diagonal of 15 needs six decimals
        ("positional", 0.5, "0.5"),
        ("positional", 2.0, "2"),
        ("positional", 1.0000004, "1"),
        ("positional with a decimal", 2.0, "2.0"),
        ("whole", 0.25, "0.25"),
        ("general", 0.5, "0.5"),
        ("general", -2.5e-5, "-2.5e-05"),
        ("general", 1e-3, "0.001"),
        ("exponent", 0.5, "5.0000000e-01"),
        ("exponent capital", 0.5, "5.0000000E-01"),
        ("shortest", 1 / 3, "0.3333333333333333"),
        ("shortest", 3e-20, "3e-20"),
        ("shortest without exponents", 3e-10, "0.0000000003"),
    ],
)
def test_numbers_look_like_the_files_own(name: str, value: float, expected: str) -> None:
    words = STYLES[name] + STYLES[name][::-1]
    text = positions(words)
    moved = text.values.copy()
    moved[0, 0] = value
    assert text.patch(moved).decode().split() == [expected, *words[1:]]


@pytest.mark.parametrize("name", STYLES)
@settings(max_examples=40)
@given(vertices=rows)
def test_what_is_written_is_what_conform_says(name: str, vertices: list[tuple[float, float, float]]) -> None:
    text = positions(STYLES[name] * len(vertices))
    moved = np.array(vertices)
    conformed = text.conform(moved)
    written = text.patch(moved)
    np.testing.assert_array_equal([float(word) for word in written.split()], conformed.ravel())
    np.testing.assert_array_equal(text.conform(conformed), conformed)
    assert text.patch(conformed) == written
    diagonal = np.linalg.norm(np.ptp(conformed, axis=0))
    rounding = np.abs(moved).max() * 2e-16
    # Where the whole extent is below the precision of a double, nothing of it is left to be resolved.
    assert np.abs(conformed - moved).max() <= 0.51e-7 * diagonal + rounding or diagonal == 0


@pytest.mark.parametrize("name", STYLES)
@pytest.mark.parametrize("scale", [1e-12, 1e-3, 1.0, 1e5, 1e30])
def test_a_ten_millionth_of_the_diagonal_is_resolved_at_any_scale(name: str, scale: float) -> None:
    text = positions(STYLES[name] * 40)
    moved = scale * np.random.default_rng(1).standard_normal(text.values.shape)
    diagonal = np.linalg.norm(np.ptp(moved, axis=0))
    assert np.abs(text.conform(moved) - moved).max() <= 0.51e-7 * diagonal


@given(st.lists(st.floats(-1e8, 1e8), min_size=1), st.integers(1, 12))
def test_fixed_decimals_equal_percent_formatting_of_the_rounded(numbers: list[float], digits: int) -> None:
    style = NumberStyle(kind="fixed", significant=6, decimals=digits, least=digits)
    rounded = round_numbers(style, digits, np.array(numbers))
    letters, lengths = format_numbers(style, digits, rounded)
    words = [f"{value:.{digits}f}" for value in rounded.tolist()]
    assert letters.tobytes().decode() == "".join(words)
    assert lengths.tolist() == [len(word) for word in words]


@given(st.lists(st.floats(-1e12, 1e12), min_size=1), st.integers(1, 15))
def test_general_equals_percent_g(numbers: list[float], digits: int) -> None:
    style = NumberStyle(kind="general", significant=digits, decimals=digits, least=0, exponents=True)
    rounded = round_numbers(style, digits, np.array(numbers))
    letters, lengths = format_numbers(style, digits, rounded)
    words = [
        letters.tobytes()[end - size : end].decode()
        for end, size in zip(np.cumsum(lengths), lengths, strict=True)
    ]
    for value, word in some(zip(rounded.tolist(), words, strict=True)):
        plain = f"{value:.{digits}g}"
        # At the very power of ten where %g turns to an exponent, both forms say the same.
        assert word == plain or float(word) == float(plain)
        assert len(re.sub(r"e.*|[-.]", "", word).strip("0")) <= digits


@pytest.mark.parametrize("name", STYLES)
def test_kind_is_recognised(name: str) -> None:
    text = positions(STYLES[name])
    kind = {"whole": "positional"}.get(name, name.split()[0])
    assert text.style.kind == kind
    assert "text" in text.describe()


def test_digits_are_never_fewer_than_the_files_own() -> None:
    text = positions(["0.12345678901", "100000.00000000000", "3.00000000000"])
    assert digits_needed(text.style, text.values) == 11


def test_new_positions_must_fit() -> None:
    text = positions(STYLES["fixed"])
    with pytest.raises(InputError, match="shape"):
        text.conform(np.zeros((2, 3)))
    with pytest.raises(InputError, match="finite"):
        text.patch(np.full((1, 3), np.nan))


def test_style_is_read_from_the_spans_only() -> None:
    data = b"1e5 v 0.50 name.with.dots 0.25 0.75"
    tokens = tokenise(data)
    chosen = np.array([2, 4, 5])
    style = detect_style(tokens.text, tokens.starts[chosen], tokens.ends[chosen], np.array([0.5, 0.25, 0.75]))
    assert (style.kind, style.decimals) == ("fixed", 2)


def test_edits_merge_in_order() -> None:
    def edit(starts: list[int], ends: list[int], words: list[bytes]) -> tuple[np.ndarray, ...]:
        letters = np.frombuffer(b"".join(words), dtype=np.uint8)
        return np.array(starts), np.array(ends), letters, np.array([len(word) for word in words])

    first, second = edit([0, 8], [1, 10], [b"ZERO", b""]), edit([4], [6], [b"!"])
    assert splice(b"0123456789", *merge_edits(first, second)) == b"ZERO123!67"
