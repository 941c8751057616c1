"""The id of votes for its pieces, also where pieces are missing."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.authentication.checks.marked_ids import marked_ids
from meshmark.authentication.marks.symbols import header_symbols, ids_of_votes
from meshmark.geometry.surface_of import surface_of
from tests.keys import ID, KEY, OTHER_ID
from tests.marked import marked_pebble

WIDE, NARROW = 10, 6
"""Bits of a symbol that carries 8 bits of the id, and 4."""


def votes(identity: int, pieces: list[int], symbol_bits: int) -> tuple[np.ndarray, np.ndarray]:
    """Return indices and symbols of one mark for each of these pieces."""
    index = np.array(pieces, np.uint32)
    return index, header_symbols(index, identity, symbol_bits)


@pytest.mark.parametrize(("symbol_bits", "pieces"), [(WIDE, 8), (NARROW, 16)])
def test_votes_for_all_pieces_give_the_id_first(symbol_bits, pieces):
    index, symbol = votes(ID, [*range(pieces)] * 2, symbol_bits)
    ids = ids_of_votes(index, symbol, np.ones(len(index)), symbol_bits, 1 << 16)
    assert int(ids[0]) == ID
    assert 1 <= len(ids) <= 512


@pytest.mark.parametrize(
    ("symbol_bits", "pieces", "missing"), [(WIDE, 8, [3]), (WIDE, 8, [0, 7]), (NARROW, 16, [0, 5, 15])]
)
def test_all_values_of_missing_pieces_are_tried(symbol_bits, pieces, missing):
    index, symbol = votes(ID, [piece for piece in range(pieces) if piece not in missing], symbol_bits)
    ids = ids_of_votes(index, symbol, np.ones(len(index)), symbol_bits, 1 << 16)
    assert ID in ids.tolist()
    assert len(np.unique(ids)) == len(ids) >= (1 << 64 // pieces) ** len(missing)


def test_too_many_missing_pieces_are_not_tried():
    index, symbol = votes(ID, [0, 1, 2, 4, 6], WIDE)
    assert not len(ids_of_votes(index, symbol, np.ones(len(index)), WIDE, 1 << 16))


def test_second_values_are_tried_where_votes_are_divided():
    index, symbol = votes(ID, [*range(8)] * 2, WIDE)
    wrong_index, wrong = votes(OTHER_ID, [1, 1, 1, 6, 6, 6], WIDE)
    index, symbol = np.concatenate([index, wrong_index]), np.concatenate([symbol, wrong])
    ids = ids_of_votes(index, symbol, np.ones(len(index)), WIDE, 1 << 16)
    assert int(ids[0]) != ID
    assert ID in ids.tolist()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_three_tenths_of_a_model_have_its_id(seed):
    attack = parse_chain("crop:0.7+similarity:1+shuffle:1+float32:1")
    found = marked_ids(surface_of(attack(marked_pebble().mesh, np.random.default_rng(seed))), KEY)
    assert [each.id for each in found] == [ID]
