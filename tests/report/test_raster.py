from __future__ import annotations

import numpy as np
import pytest

from meshmark.mesh import FloatArray, IntArray
from meshmark.report import raster
from meshmark.report.raster import EMPTY, rasterise

RNG = np.random.default_rng(4)


def brute_force(screen: FloatArray, faces: IntArray, width: int, height: int) -> IntArray:
    """Test every pixel centre against every triangle by the signs of three cross products."""
    y, x = np.mgrid[:height, :width] + 0.5
    nearest = np.full((height, width), np.inf)
    seen = np.full((height, width), EMPTY)
    for index, face in enumerate(faces):
        (xa, ya, za), (xb, yb, zb), (xc, yc, zc) = screen[face]
        whole = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
        b = ((x - xa) * (yc - ya) - (xc - xa) * (y - ya)) / whole
        c = ((xb - xa) * (y - ya) - (x - xa) * (yb - ya)) / whole
        depth = za + b * (zb - za) + c * (zc - za)
        hit = (b >= 0) & (c >= 0) & (b + c <= 1) & (depth < nearest)
        nearest[hit], seen[hit] = depth[hit], index
    return seen


@pytest.mark.parametrize("spread", [3.0, 40.0])
@pytest.mark.parametrize("at_once", [50, 1 << 21])
def test_equals_brute_force(monkeypatch: pytest.MonkeyPatch, spread: float, at_once: int) -> None:
    monkeypatch.setattr(raster, "PIXELS_AT_ONCE", at_once)
    middle = RNG.random((60, 1, 2)) * [60.0, 40.0]
    flat = middle + RNG.normal(size=(60, 3, 2)) * spread
    screen = np.concatenate([flat, RNG.random((60, 3, 1))], axis=2).reshape(-1, 3)
    faces = np.arange(180).reshape(-1, 3)
    np.testing.assert_array_equal(rasterise(screen, faces, 60, 40), brute_force(screen, faces, 60, 40))


def test_neighbours_share_their_edge_without_gap_or_overlap() -> None:
    grid = np.stack(np.meshgrid(np.arange(11.0), np.arange(11.0), [0.5]), axis=-1).reshape(-1, 3)
    grid[:, :2] *= 7.3
    at = np.arange(121).reshape(11, 11)
    low = np.stack([at[:-1, :-1], at[:-1, 1:], at[1:, :-1]], -1).reshape(-1, 3)
    high = np.stack([at[:-1, 1:], at[1:, 1:], at[1:, :-1]], -1).reshape(-1, 3)
    for turned in (np.concatenate([low, high]), np.concatenate([high, low])[:, ::-1]):
        assert (rasterise(grid, turned, 73, 73) != EMPTY).all()


def test_nothing_to_draw_and_edge_on_triangles_leave_the_picture_empty() -> None:
    assert (rasterise(np.zeros((0, 3)), np.zeros((0, 3), np.int64), 5, 4) == EMPTY).all()
    line = np.array([[0, 0, 0], [4, 4, 0], [8, 8, 0]], float)
    assert (rasterise(line, np.array([[0, 1, 2]]), 8, 8) == EMPTY).all()
