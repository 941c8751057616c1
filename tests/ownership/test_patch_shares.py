"""How much each patch counts at a cell."""

from __future__ import annotations

import numpy as np

from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.patch_shares import patch_shares

UP = np.array([0.0, 0.0, 1.0])


def cells_at(*nodes: tuple[int, int, int]) -> Cells:
    count = len(nodes)
    return Cells(
        nodes=np.array(nodes),
        offset=np.zeros(count),
        normal=np.tile(UP, (count, 1)),
        mass=np.ones(count),
        flatness=np.ones(count),
    )


def test_shares_are_those_of_a_gaussian_of_the_distance_on_the_side_that_a_cell_faces():
    centres = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 1, 0]])
    normals = np.array([UP, UP, -UP, [0.6, 0.0, 0.8]])
    (shares,) = patch_shares(cells_at((0, 0, 0)), centres, normals)
    weight = np.array([1.0, np.exp(-2.0), 0.0, 0.8 * np.exp(-2.0)])
    np.testing.assert_allclose(shares, weight / weight.sum(), rtol=1e-12)
    assert shares[2] == 0.0


def test_far_patches_count_nothing_at_all_and_a_cell_without_any_looks_at_all_alike():
    centres = np.array([[0.0, 0, 0], [12, 0, 0]])
    shares = patch_shares(cells_at((0, 0, 0), (500, 0, 0)), centres, np.tile(UP, (2, 1)))
    assert shares[0].tolist() == [1.0, 0.0]
    np.testing.assert_allclose(shares[1], 0.5)
