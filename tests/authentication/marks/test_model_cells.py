"""Masks of symbols by the cell of the model in which a mark lies."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.marks.model_cells import cells_of, masks, near_cells
from meshmark.coding.keys import Key

KEY = Key(bytes(range(32)))


def test_cells_are_cubes_of_a_sixteenth_and_larger_for_coarse_symbols():
    places = np.array([[0.0, 0.0624, -0.01], [0.99, -1.0, 0.0626]])
    assert cells_of(places, 10).tolist() == [[0, 0, -1], [15, -16, 1]]
    assert cells_of(places, 4).tolist() == [[0, 0, -1], [3, -4, 0]]


@pytest.mark.parametrize("seed", range(5))
def test_near_cells_are_those_of_all_corners_of_a_box_about_the_place(seed):
    random = np.random.default_rng(seed)
    places, doubt = random.uniform(-1.0, 1.0, (50, 3)), random.uniform(0.0, 0.03, 50)
    row, cells = near_cells(places, doubt, 10)
    assert (np.diff(row) >= 0).all()
    for number in range(50):
        own = {tuple(cell) for cell in cells[row == number].tolist()}
        signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3)
        corners = {tuple(cell) for cell in cells_of(places[number] + doubt[number] * signs, 10).tolist()}
        assert own == corners
        assert cells[row == number][0].tolist() == cells_of(places[number : number + 1], 10)[0].tolist()


def test_masks_depend_on_key_id_ring_and_cell_and_fill_the_symbol():
    ring, cells = np.arange(2000, dtype=np.uint64), np.zeros((2000, 3), np.int64)
    plain = masks(KEY, 7, 10)(ring, cells)
    assert np.array_equal(plain, masks(KEY, 7, 10)(ring, cells))
    assert plain.min() >= 0
    assert plain.max() < 1 << 10
    assert len(np.unique(plain)) > 800
    others = [
        masks(Key(bytes(32)), 7, 10)(ring, cells),
        masks(KEY, 8, 10)(ring, cells),
        masks(KEY, 7, 10)(ring + np.uint64(1), cells),
        masks(KEY, 7, 10)(ring, cells + np.array([0, 0, 1])),
    ]
    assert max((plain == other).mean() for other in others) < 0.01
