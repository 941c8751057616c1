from __future__ import annotations

import numpy as np

from meshmark.coding.keys import Key
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label

KEY = Key(bytes(range(32)))


def test_coordinates_are_a_similarity_and_points_undo_them():
    lattice = Lattice.keyed(KEY, 0.2)
    points = np.random.default_rng(0).normal(size=(50, 3))
    there = lattice.coordinates(points)
    np.testing.assert_allclose(lattice.points(there), points, atol=1e-14)
    np.testing.assert_allclose(
        np.linalg.norm(there[1:] - there[:-1], axis=1), np.linalg.norm(points[1:] - points[:-1], axis=1) / 0.2
    )


def test_everything_of_a_cell_comes_from_key_spacing_and_coordinates():
    nodes = np.random.default_rng(1).integers(-9, 9, size=(400, 3))
    keys = Lattice.keyed(KEY, 0.2).keys(nodes)
    again = Lattice.keyed(KEY, 0.2).keys(nodes[::-1])
    np.testing.assert_array_equal(keys.dither, again.dither[::-1])
    np.testing.assert_array_equal(keys.code_index, again.code_index[::-1])
    assert keys.dither.min() >= 0
    assert keys.dither.max() < 1
    assert keys.code_index.min() >= 0
    assert keys.code_index.max() < 4096
    for other in (Lattice.keyed(KEY, 0.21), Lattice.keyed(Key(bytes(32)), 0.2)):
        assert (other.keys(nodes).dither != keys.dither).all()


def test_lattices_of_two_labels_have_nothing_in_common_and_none_is_a_third():
    nodes = np.random.default_rng(2).integers(-9, 9, size=(400, 3))
    one, other, none = (
        Lattice.keyed(KEY, 0.2, label) for label in (Label(bytes(16)), Label(bytes([1] * 16)), None)
    )
    for a, b in ((one, other), (one, none)):
        assert np.abs(a.axes - b.axes).max() > 0.1
        assert (a.shift != b.shift).all()
        assert (a.keys(nodes).dither != b.keys(nodes).dither).all()
    again = Lattice.keyed(KEY, 0.2, Label(bytes(16)))
    np.testing.assert_array_equal(again.axes, one.axes)
    np.testing.assert_array_equal(again.keys(nodes).dither, one.keys(nodes).dither)
