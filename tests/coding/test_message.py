from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.coding.message import (
    PRESENCE,
    bits_of,
    format_id,
    parse_id,
    random_id,
    requested_id,
    short_id,
    told_id,
)
from meshmark.errors import InputError


@given(st.integers(0, 2**64 - 1))
def test_an_id_is_16_hexadecimal_digits(identity: int) -> None:
    assert format_id(identity) == f"{identity:016x}"
    assert parse_id(format_id(identity)) == identity
    assert parse_id(format_id(identity).upper()) == identity
    assert bits_of(identity) == 64


@pytest.mark.parametrize(
    "text", ["", "1", "0" * 15, "0" * 17, "0x" + "0" * 14, "g" * 16, " " + "0" * 15, "٣" * 16]
)
def test_other_texts_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="expected 16 hexadecimal digits, or 8 of an id of 32 bits"):
        parse_id(text)


@given(st.integers(0, 2**32 - 1))
def test_an_id_of_32_bits_is_8_hexadecimal_digits(serial: int) -> None:
    identity = short_id(serial)
    assert format_id(identity) == f"{serial:08x}"
    assert parse_id(format_id(identity)) == requested_id(serial, 32) == identity
    assert (bits_of(identity), bits_of(serial)) == (32, 64)
    assert identity != serial


def test_the_mark_without_an_id_has_no_digits() -> None:
    assert bits_of(PRESENCE) == 0
    assert told_id(PRESENCE) is told_id(None) is None
    assert told_id(short_id(7)) == short_id(7)
    with pytest.raises(InputError, match="stands for a mark without an id"):
        format_id(PRESENCE)


@pytest.mark.parametrize(
    ("identity", "bits", "why"),
    [
        (short_id(7), 64, "the id is one of 32 bits, expected 16 hexadecimal digits"),
        (2**32, 32, "the id 4294967296 is not a 32-bit number"),
        (PRESENCE, 32, "a mark of 32 bits carries an id"),
        (7, 0, "a mark of 0 bits carries no id"),
        (7, 16, "an id of 16 bits is not known, expected one of 64, 32, 0"),
        (2**64, 64, "not a 64-bit number"),
    ],
)
def test_an_id_of_other_bits_than_asked_for_is_refused(identity: int, bits: int, why: str) -> None:
    with pytest.raises(InputError, match=why):
        requested_id(identity, bits)


@pytest.mark.parametrize(
    ("text", "bits", "why"),
    [("0" * 16, 32, "one of 64 bits, expected 8 "), ("0" * 8, 64, "one of 32 bits, expected 16 "),
     ("0" * 8, 0, "expected none with 0 bits")],
)  # fmt: skip
def test_a_text_of_other_bits_than_asked_for_is_refused(text: str, bits: int, why: str) -> None:
    assert bits_of(parse_id(text, 4 * len(text))) == 4 * len(text)
    with pytest.raises(InputError, match=why):
        parse_id(text, bits)


def test_an_id_is_drawn_of_as_many_bits_as_asked_for() -> None:
    assert [bits_of(requested_id(None, bits)) for bits in (64, 32, 0)] == [64, 32, 0]


@pytest.mark.parametrize("identity", [-1, 2**64, 2**96 - 1, 2**96 + 2**32])
def test_other_numbers_are_refused(identity: int) -> None:
    with pytest.raises(InputError, match="not a 64-bit number"):
        format_id(identity)


def test_random_ids_differ() -> None:
    assert len({random_id() for _ in range(100)}) == 100
