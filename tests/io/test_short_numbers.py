"""Numbers in texts against Python's own `float` and `int`."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.errors import FormatError
from meshmark.io.text.numbers import compact, line_number, parse_floats, parse_ints, span_mask
from meshmark.io.text.short_numbers import read_short_floats, read_short_ints
from meshmark.io.text.tokens import tokenise
from tests.counting import some

decimals = st.from_regex(
    r"[-+]?([0-9]{1,20}(\.[0-9]{0,20})?|\.[0-9]{1,20})([eE][-+]?[0-9]{1,2})?", fullmatch=True
)
shortest = st.floats(allow_nan=False, allow_infinity=False).map(repr)


def spans(words: list[str], before: str = "") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    tokens = tokenise((before + " ".join(words)).encode())
    skip = len(before.split())
    return tokens.text, tokens.starts[skip:], tokens.ends[skip:]


@given(st.lists(decimals | shortest, min_size=1), st.sampled_from(["", "x ", "a longer start of the text "]))
def test_floats_equal_python_bit_for_bit(words: list[str], before: str) -> None:
    found = parse_floats(*spans(words, before))
    np.testing.assert_array_equal(found.view(np.int64), np.array([float(w) for w in words]).view(np.int64))


@given(st.lists(decimals | shortest | st.text("0123456789+-.eE/x", min_size=1), min_size=1))
def test_what_the_short_reader_accepts_is_right(words: list[str]) -> None:
    values, good = read_short_floats(*spans(words))
    for word, value, fine in some(zip(words, values, good, strict=True)):
        assert not fine or np.array(float(word)).view(np.int64) == value.view(np.int64)


def test_ordinary_coordinates_take_the_short_way() -> None:
    words = ["0.123456", "-12.5", "+3", "7.", ".5", "-0.000000", "0.1234567890123", "99999999.125"]
    assert read_short_floats(*spans(words))[1].all()
    assert read_short_ints(*spans(["0", "-1", "+12345678", "99999999"]))[1].all()


@given(st.lists(st.integers(-(2**63) + 1, 2**63 - 1), min_size=1))
def test_whole_numbers_equal_python(numbers: list[int]) -> None:
    np.testing.assert_array_equal(parse_ints(*spans([str(n) for n in numbers])), numbers)


@given(st.integers(2**63, 2**80))
def test_whole_numbers_beyond_64_bits_stay_beyond_any_index(number: int) -> None:
    assert (abs(parse_ints(*spans([str(number), str(-number)])).astype(object)) >= 2**63 - 1).all()


@pytest.mark.parametrize(
    "word",
    [
        "x",
        "1,5",
        "1.5.2",
        "1_0",
        "0x10",
        "--1",
        "1e",
        "e5",
        ".",
        "-",
        "1d5",
        "½",
        "1-2",
        "nan",
        "-inf",
        "1e400",
    ],
)
def test_what_is_no_finite_number_is_refused_with_its_line(word: str) -> None:
    text, starts, ends = spans(["1", "2.5", word, "3"], "first line\n\r\n")
    with pytest.raises(FormatError, match=r"^line 3 has '.*' where a (finite )?number is expected$"):
        parse_floats(text, starts, ends)


@pytest.mark.parametrize("word", ["1.0", "x", "1/2", "", "1e3"])
def test_what_is_no_whole_number_is_refused(word: str) -> None:
    text = np.frombuffer(f"7 {word} 8".encode(), dtype=np.uint8)
    with pytest.raises(FormatError, match="where a whole number is expected"):
        parse_ints(text, np.array([0, 2]), np.array([1, 2 + len(word)]))


def test_the_first_of_many_bad_words_is_named() -> None:
    words = ["1.5"] * 200_000
    words[150_000] = words[199_999] = "bad"
    text, starts, ends = spans(words)
    with pytest.raises(FormatError, match="'bad'"):
        parse_floats(text, starts, ends)
    assert line_number(np.frombuffer(b"a\nb\rc\r\nd", dtype=np.uint8), 7) == 4


def test_messages_stay_printable() -> None:
    with pytest.raises(FormatError) as caught:
        parse_floats(*spans(["\x1b[0m" + "\u202e" * 100]))
    assert str(caught.value).isascii()
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 250


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(1, 3)), min_size=1))
def test_span_mask_and_compact(gaps: list[tuple[int, int]]) -> None:
    starts, ends, place = [], [], 0
    for gap, length in gaps:
        starts.append(place + gap)
        ends.append(place + gap + length)
        place += gap + length
    mask = np.zeros(place, dtype=bool)
    for start, end in zip(starts, ends, strict=True):
        mask[start:end] = True
    np.testing.assert_array_equal(span_mask(place, np.array(starts), np.array(ends)), mask)
    apart = [start + k for k, start in enumerate(starts)], [end + k for k, end in enumerate(ends)]
    text = np.arange(65, 65 + place + len(starts) - 1, dtype=np.uint8)
    joined = b"".join(text[a:b].tobytes() + b" " for a, b in zip(*apart, strict=True))
    assert compact(text, np.array(apart[0]), np.array(apart[1])).tobytes() == joined
