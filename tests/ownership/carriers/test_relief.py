"""The answers of offsets to smoothing and noise, against moving the points and reading again."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.connectivity import Connectivity
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.scale_space import random_walk
from meshmark.ownership.carriers.cells import measure_cells
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.relief import Umbrellas, measure_relief
from meshmark.ownership.carriers.selection import select_cells
from tests.shapes import pebble


@pytest.fixture(scope="module")
def placed():
    points, faces = pebble(140)
    return points / np.abs(points).max() * 3.0 + 0.3, faces


def joined(faces):
    return Connectivity(count=faces.max() + 1, faces=faces)


def read(points, faces):
    cells = measure_cells(plan_samples(points, faces, 0.25)(points))
    return cells.take(select_cells(cells, (0.35, 0.7, 0.5)))


def offsets_of(points, faces, cells):
    after = measure_cells(plan_samples(points, faces, 0.25)(points))
    rows = find_nodes(after.nodes, cells.nodes)
    assert (rows >= 0).all()
    return after.offset[rows]


@pytest.mark.parametrize(("roughness", "limits"), [(0.0, (0.01, 0.15)), (0.004, (0.03, 0.35))])
def test_bending_is_what_a_little_smoothing_does(placed, roughness, limits):
    points, faces = placed
    rough = points + roughness * np.random.default_rng(1).normal(size=points.shape)
    cells = read(rough, faces)
    relief = measure_relief(rough, Umbrellas.of(rough, joined(faces)), cells)
    walk = random_walk(rough, unique_edges(faces))
    first = walk @ rough - rough
    for column, move in enumerate((first, walk @ first - first)):
        ahead, behind = (offsets_of(rough + share * move, faces, cells) for share in (0.05, -0.05))
        change = (ahead - behind) / 0.1
        assert np.std(relief.bending[:, column] - change) < limits[column] * np.std(change)


def test_grain_is_the_spread_that_noise_makes(placed):
    points, faces = placed
    rng = np.random.default_rng(2)
    cells = read(points, faces)
    amount = 0.01
    draws = np.array(
        [
            offsets_of(points + amount * rng.normal(size=points.shape), faces, cells) - cells.offset
            for _ in range(40)
        ]
    )
    # The umbrella of pure noise is larger than the noise: by sqrt(1 + 1/6) where a point has six neighbours.
    noisy = points + amount * rng.normal(size=points.shape)
    grain = measure_relief(noisy, Umbrellas.of(noisy, joined(faces)), cells).grain / np.sqrt(1.0 + 1.0 / 6.0)
    ratio = grain / draws.std(axis=0)
    assert 0.8 < np.median(ratio) < 1.25


def test_rows_follow_their_cells_and_inputs_stay(placed):
    points, faces = placed
    points, faces = points.copy(), faces.copy()
    points.setflags(write=False)
    faces.setflags(write=False)
    cells = read(points, faces)
    relief = measure_relief(points, Umbrellas.of(points, joined(faces)), cells)
    index = np.array([5, 0, 3])
    part = measure_relief(points, Umbrellas.of(points, joined(faces)), cells.take(index))
    np.testing.assert_allclose(part.bending, relief.take(index).bending, rtol=1e-12)
    np.testing.assert_allclose(part.grain, relief.take(index).grain, rtol=1e-12)
