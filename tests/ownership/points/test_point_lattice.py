"""What the key says of a point hangs on its cube, on the key and on the label, and on nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keyed_code import LENGTH
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.points.parameters import SIDE
from meshmark.ownership.points.point_lattice import PointLattice, distinct_cubes
from tests.keys import KEY, OTHER

LABEL, ANOTHER = Label(bytes(16)), Label(bytes(range(16)))


def cubes_at(count: int = 2000, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).integers(-30, 30, (count, 3))


def test_points_of_one_cube_are_told_the_same_whatever_else_is_there():
    lattice, cubes = PointLattice.keyed(KEY, LABEL), cubes_at()
    whole, part = lattice.keys(cubes), lattice.keys(cubes[::-7])
    for name in ("code_index", "dither", "draw", "first"):
        np.testing.assert_array_equal(getattr(whole, name)[::-7], getattr(part, name))
    _, row = distinct_cubes(cubes)
    first = np.unique(row, return_index=True)[1][row]
    assert (first != np.arange(len(cubes))).any()
    np.testing.assert_array_equal(whole.dither, whole.dither[first])


@pytest.mark.parametrize(("key", "label"), [(OTHER, LABEL), (KEY, ANOTHER)])
def test_another_key_or_label_says_something_else(key, label):
    one, other = PointLattice.keyed(KEY, LABEL), PointLattice.keyed(key, label)
    keys, others = one.keys(cubes_at()), other.keys(cubes_at())
    assert not np.allclose(one.axes, other.axes, atol=0.01)
    assert (keys.code_index == others.code_index).mean() < 10.0 / LENGTH
    assert abs(np.corrcoef(keys.dither.ravel(), others.dither.ravel())[0, 1]) < 0.05


def test_what_it_says_is_spread_evenly_and_each_coordinate_has_its_own():
    keys = PointLattice.keyed(KEY, LABEL).keys(np.unique(cubes_at(8000), axis=0))
    for values in (keys.dither, keys.draw):
        assert values.min() >= 0.0
        assert values.max() < 1.0
        shares = np.histogram(values, 10, (0.0, 1.0))[0] / values.size
        np.testing.assert_allclose(shares, 0.1, atol=0.01)
        assert np.abs(np.corrcoef(values.T) - np.eye(3)).max() < 0.05
    assert keys.code_index.min() >= 0
    assert keys.code_index.max() < LENGTH
    assert np.bincount(keys.code_index.ravel(), minlength=LENGTH).max() < 30
    assert abs(np.corrcoef(keys.dither.ravel(), keys.draw.ravel())[0, 1]) < 0.05
    np.testing.assert_allclose(np.bincount(keys.first) / len(keys.first), np.ones(3) / 3.0, atol=0.02)
    assert max(abs(np.corrcoef(keys.first, each)[0, 1]) for each in (*keys.draw.T, *keys.code_index.T)) < 0.05


def test_cubes_have_their_side_and_are_turned_and_shifted():
    lattice = PointLattice.keyed(KEY, LABEL)
    points = np.random.default_rng(2).normal(size=(100, 3))
    places = lattice.places(points)
    gaps = np.linalg.norm(places[1:] - places[:-1], axis=1)
    np.testing.assert_allclose(gaps * SIDE, np.linalg.norm(np.diff(points, axis=0), axis=1))
    np.testing.assert_array_equal(lattice.cubes(points), np.floor(places))
    assert np.abs(lattice.axes - np.eye(3)).max() > 0.1


@pytest.mark.parametrize("reach", [20, 2**40])
def test_distinct_cubes_are_those_that_there_are(reach):
    cubes = np.random.default_rng(3).integers(-reach, reach, (50, 3)).repeat(3, axis=0)
    different, row = distinct_cubes(cubes)
    np.testing.assert_array_equal(different[row], cubes)
    assert len(different) == len(np.unique(cubes, axis=0)) == 50
    none, rows = distinct_cubes(cubes[:0])
    assert (len(none), len(rows)) == (0, 0)
