from __future__ import annotations

import struct
from hashlib import blake2b

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.coding.keyed import cell_words, keyed_bits, keyed_words, offset, rotation, unit_interval
from meshmark.errors import InputError
from tests.counting import some

SUBKEY = bytes(range(32))
CELL_WORDS = [[687463529485040999, 2004623727068734850], [199789696477109619, 13408357169418165316]]
STREAM_WORDS = [6166998254896944562, 993875990659472902]
INT64 = st.integers(-(2**63), 2**63 - 1)


@given(st.lists(st.tuples(INT64, INT64, INT64), min_size=1, max_size=5), st.integers(1, 8))
def test_cell_words_are_blake2b_of_the_coordinates(rows: list[tuple[int, int, int]], words: int) -> None:
    got = cell_words(SUBKEY, np.array(rows, dtype=np.int64).reshape(-1, 3), words)
    assert got.shape == (len(rows), words)
    assert got.dtype == np.uint64
    for row, values in some(zip(rows, got, strict=True)):
        message = struct.pack("<3q", *row)
        digest = blake2b(message, digest_size=8 * words, key=SUBKEY, person=b"meshmark cell 1").digest()
        assert values.tolist() == list(struct.unpack(f"<{words}Q", digest))


def test_cell_words_never_change() -> None:
    """Numbers printed by Python 3.11's hashlib.blake2b; another value would orphan every mark ever made."""
    words = cell_words(bytes(32), np.array([[0, 0, 0], [1, -2, 3]]), 2)
    assert words.tolist() == CELL_WORDS
    assert keyed_words(bytes(32), 2).tolist() == STREAM_WORDS


def test_cell_words_take_any_layout_and_refuse_other_counts() -> None:
    cells = np.arange(30, dtype=np.int64).reshape(10, 3)
    assert np.array_equal(cell_words(SUBKEY, np.asfortranarray(cells)), cell_words(SUBKEY, cells))
    assert np.array_equal(cell_words(SUBKEY, cells.astype(np.int32)), cell_words(SUBKEY, cells))
    for words in (0, 9):
        with pytest.raises(InputError, match="expected 1 to 8"):
            cell_words(SUBKEY, cells, words)


def test_cell_words_look_random_and_depend_on_the_key() -> None:
    grid = np.stack(np.meshgrid(*[np.arange(-8, 8)] * 3), axis=-1).reshape(-1, 3)
    words = cell_words(SUBKEY, grid)
    bits = np.unpackbits(words.view(np.uint8), axis=1).astype(float)
    limit = 5.0 / np.sqrt(len(grid))
    assert np.abs(2.0 * bits.mean(axis=0) - 1.0).max() < limit
    other = np.unpackbits(cell_words(SUBKEY[::-1], grid).view(np.uint8), axis=1)
    assert np.abs(2.0 * (bits == other).mean(axis=0) - 1.0).max() < limit
    assert len(np.unique(words)) == words.size


def test_the_stream_is_blake2b_of_a_counter() -> None:
    blocks = [
        blake2b(i.to_bytes(8, "little"), digest_size=64, key=SUBKEY, person=b"meshmark strm 1").digest()
        for i in range(3)
    ]
    expected = struct.unpack("<24Q", b"".join(blocks))
    assert keyed_words(SUBKEY, 24).tolist() == list(expected)
    for count in (0, 1, 8, 9):
        assert keyed_words(SUBKEY, count).tolist() == list(expected[:count])
    bits = [word >> j & 1 for word in expected for j in range(64)]
    for count in (0, 1, 64, 65, 1000):
        assert keyed_bits(SUBKEY, count).tolist() == bits[:count]


def test_unit_interval_is_half_open() -> None:
    ends = unit_interval(np.array([0, 2**64 - 1], dtype=np.uint64))
    assert ends.tolist() == [0.0, 1.0 - 2.0**-53]


def test_offset_and_rotation_are_keyed_and_of_their_kind() -> None:
    subkeys = [bytes([i]) * 32 for i in range(200)]
    offsets = np.array([offset(key) for key in subkeys])
    turns = np.array([rotation(key) for key in subkeys])
    assert offsets.min() >= 0.0
    assert offsets.max() < 1.0
    assert np.allclose(turns @ turns.transpose(0, 2, 1), np.eye(3), atol=1e-14)
    assert np.allclose(np.linalg.det(turns), 1.0, atol=1e-14)
    # Uniform rotations: every entry has mean 0 and mean square 1/3.
    assert np.abs(turns.mean(axis=0)).max() < 0.2
    assert np.abs((turns**2).mean(axis=0) - 1.0 / 3.0).max() < 0.12
    assert len({turn.tobytes() for turn in turns}) == len(subkeys)
    assert np.array_equal(rotation(subkeys[0]), rotation(subkeys[0]))
