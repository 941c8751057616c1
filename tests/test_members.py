"""Members of groups in a flat list."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from meshmark.arrays import members


@given(st.lists(st.integers(0, 5)))
def test_members(sizes: list[int]) -> None:
    group, place = members(np.array(sizes, dtype=np.int64))
    pairs = [(row, k) for row, size in enumerate(sizes) for k in range(size)]
    assert list(zip(group.tolist(), place.tolist(), strict=True)) == pairs
