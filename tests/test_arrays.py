"""What numpy does in a faster way is the same as in the plainest."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.arrays import members, rows_of, sorted_distinct

VALUES = np.random.default_rng(1).normal(size=(40, 3))


@pytest.mark.parametrize(
    "rows",
    [
        np.array([3, 0, 3, -1], np.int32),
        np.zeros(0, np.int64),
        np.arange(40) % 3 == 0,
        np.zeros(40, bool),
        slice(4, 9),
        np.array([[1, 2], [0, 39]]),
    ],
    ids=["numbers", "none", "chosen", "none chosen", "slice", "table"],
)
@pytest.mark.parametrize("values", [VALUES, VALUES[:, 0], VALUES[:, 1:]], ids=["table", "column", "part"])
def test_rows_are_those_of_indexing(values, rows):
    found = rows_of(values, rows)
    np.testing.assert_array_equal(found, values[rows])
    assert found.shape == values[rows].shape


@pytest.mark.parametrize("kind", [np.uint64, np.int64, np.int16])
def test_different_integers_are_those_of_unique(kind):
    values = np.random.default_rng(2).integers(0, 50, 200).astype(kind)
    found = sorted_distinct(values)
    np.testing.assert_array_equal(found, np.unique(values))
    assert found.dtype == kind
    assert 20 < len(found) < len(values)


def test_of_none_there_are_no_different_ones():
    assert len(sorted_distinct(np.zeros(0, np.uint64))) == 0


def test_numbers_beyond_the_signed_range_stay_in_order():
    values = np.array([2**64 - 1, 5, 2**63, 5], np.uint64)
    assert sorted_distinct(values).tolist() == [5, 2**63, 2**64 - 1]


@given(st.lists(st.integers(0, 5)))
def test_members(sizes: list[int]) -> None:
    group, place = members(np.array(sizes, dtype=np.int64))
    pairs = [(row, k) for row, size in enumerate(sizes) for k in range(size)]
    assert list(zip(group.tolist(), place.tolist(), strict=True)) == pairs
