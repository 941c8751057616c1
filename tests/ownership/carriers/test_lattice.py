from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.ownership.carriers.lattice import DOUBLED, PILOTS, CellKeys, Lattice
from meshmark.ownership.carriers.lattice_label import Label

LABEL = Label(bytes(16))
KEY = Key(bytes(range(32)))


def test_coordinates_are_a_similarity_and_points_undo_them():
    lattice = Lattice.keyed(KEY, 0.2, LABEL)
    points = np.random.default_rng(0).normal(size=(50, 3))
    there = lattice.coordinates(points)
    np.testing.assert_allclose(lattice.points(there), points, atol=1e-14)
    np.testing.assert_allclose(
        np.linalg.norm(there[1:] - there[:-1], axis=1), np.linalg.norm(points[1:] - points[:-1], axis=1) / 0.2
    )


def test_everything_of_a_cell_comes_from_key_spacing_and_coordinates():
    nodes = np.random.default_rng(1).integers(-9, 9, size=(400, 3))
    keys = Lattice.keyed(KEY, 0.2, LABEL).keys(nodes)
    again = Lattice.keyed(KEY, 0.2, LABEL).keys(nodes[::-1])
    np.testing.assert_array_equal(keys.dither, again.dither[::-1])
    np.testing.assert_array_equal(keys.code_index, again.code_index[::-1])
    np.testing.assert_array_equal(keys.pilot, again.pilot[::-1])
    assert keys.dither.min() >= 0
    assert keys.dither.max() < 1
    assert keys.code_index.min() >= 0
    assert keys.code_index.max() < 4096
    for other in (Lattice.keyed(KEY, 0.21, LABEL), Lattice.keyed(Key(bytes(32)), 0.2, LABEL)):
        assert (other.keys(nodes).dither != keys.dither).all()
        assert (other.keys(nodes).pilot != keys.pilot).any()


def test_lattices_of_two_labels_have_nothing_in_common():
    nodes = np.random.default_rng(2).integers(-9, 9, size=(400, 3))
    one, other = (Lattice.keyed(KEY, 0.2, Label(bytes([number] * 16))) for number in (0, 1))
    assert np.abs(one.axes - other.axes).max() > 0.1
    assert (one.shift != other.shift).all()
    assert (one.keys(nodes).dither != other.keys(nodes).dither).all()
    again = Lattice.keyed(KEY, 0.2, Label(bytes(16)))
    np.testing.assert_array_equal(again.axes, one.axes)
    np.testing.assert_array_equal(again.keys(nodes).dither, one.keys(nodes).dither)


def test_a_share_of_the_cells_are_pilots_whatever_their_bit_and_dither():
    nodes = np.random.default_rng(2).integers(-90, 90, size=(20_000, 3))
    keys = Lattice.keyed(KEY, 0.2, LABEL).keys(nodes)
    assert keys.pilot.mean() == pytest.approx(PILOTS, abs=0.015)
    for kind in (keys.pilot, ~keys.pilot):
        assert keys.dither[kind].mean() == pytest.approx(0.5, abs=0.03)
        assert keys.code_index[kind].mean() == pytest.approx(2047.5, abs=120.0)


def test_pilots_lock_by_single_phases_and_count_more():
    pilot = np.array([True, False, False, False, True])
    keys = CellKeys(code_index=np.arange(5), dither=np.zeros(5), pilot=pilot)
    np.testing.assert_array_equal(keys.factor, [1.0, 2.0, 2.0, 2.0, 1.0])
    np.testing.assert_allclose(keys.weight[~pilot], DOUBLED * keys.weight[0])
    assert np.mean(keys.weight**2) == pytest.approx(1.0)


def test_no_cells_have_no_weights():
    keys = Lattice.keyed(KEY, 0.2, LABEL).keys(np.zeros((0, 3), dtype=np.int64))
    assert keys.weight.shape == keys.factor.shape == (0,)
