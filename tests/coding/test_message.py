from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.coding.message import check_id, format_id, parse_id, random_id
from meshmark.errors import InputError


@given(st.integers(0, 2**64 - 1))
def test_an_id_is_16_hexadecimal_digits(identity: int) -> None:
    assert format_id(identity) == f"{identity:016x}"
    assert parse_id(format_id(identity)) == identity
    assert parse_id(format_id(identity).upper()) == identity
    assert check_id(identity) == identity


@pytest.mark.parametrize(
    "text", ["", "1", "0" * 15, "0" * 17, "0x" + "0" * 14, "g" * 16, " " + "0" * 15, "٣" * 16]
)
def test_other_texts_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="expected 16 hexadecimal digits"):
        parse_id(text)


@pytest.mark.parametrize("identity", [-1, 2**64])
def test_other_numbers_are_refused(identity: int) -> None:
    with pytest.raises(InputError, match="not a 64-bit number"):
        format_id(identity)


def test_random_ids_differ() -> None:
    assert len({random_id() for _ in range(100)}) == 100
