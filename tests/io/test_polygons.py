"""Polygons and strips as triangles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.errors import FormatError
from meshmark.io.polygons import check_indices, fan_corners, strip_triangles


@given(st.lists(st.integers(1, 7)))
def test_fans(sizes: list[int]) -> None:
    expected, begin = [], 0
    for size in sizes:
        expected += [[begin, begin + k, begin + k + 1] for k in range(1, size - 1)]
        begin += size
    assert fan_corners(np.array(sizes, dtype=np.int64)).tolist() == expected


@given(st.lists(st.integers(-1, 9)))
def test_strips(strip: list[int]) -> None:
    expected, run = [], []
    for corner in [*strip, -1]:
        if corner != -1:
            run.append(corner)
            continue
        for k in range(len(run) - 2):
            a, b, c = run[k : k + 3]
            expected.append([b, a, c] if k % 2 else [a, b, c])
        run = []
    assert strip_triangles(np.array(strip, dtype=np.int64)).tolist() == expected


def test_indices_out_of_range() -> None:
    check_indices(np.array([[0, 1, 2]]), 3)
    with pytest.raises(FormatError, match="refers to vertex 3, expected 0 to 2"):
        check_indices(np.array([[0, 1, 3]]), 3)
    with pytest.raises(FormatError, match="refers to vertex -1"):
        check_indices(np.array([[0, -1, 2]]), 3)
