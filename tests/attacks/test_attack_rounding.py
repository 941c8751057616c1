"""Rounding to grids and to 32-bit floats."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from meshmark.attacks import ATTACKS
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from tests.counting import some
from tests.shapes import pebble

MODEL = Mesh(*pebble(24))
RNG = np.random.default_rng(1)


@pytest.mark.parametrize("bits", [1, 7, 8, 10, 12, 16])
def test_quantisation_lands_on_the_grid_and_errs_by_half_a_step_at_most(bits):
    rounded = ATTACKS["quantisation"](MODEL, bits, RNG).vertices
    for before, after in some(zip(MODEL.vertices.T, rounded.T, strict=True)):
        low, step = before.min(), (before.max() - before.min()) / 2**bits
        grid = low + np.arange(2**bits + 1) * step
        assert np.isin(after, grid).all(), "exactly low + k step"
        assert np.abs(after - before).max() <= step / 2 * (1 + 1e-9)
        assert {after.min(), after.max()} == {grid[0], grid[-1]}


def test_quantisation_is_exact_in_exact_numbers():
    mesh = Mesh([[0, 0, 5], [8, 1, 5], [3.2, 0.5, 5], [4.9, 0.74, 5]], [[0, 1, 2], [1, 2, 3]])
    rounded = ATTACKS["quantisation"](mesh, 2, RNG).vertices
    expected = []
    for x, y, z in mesh.vertices.tolist():
        row = []
        for value, high in ((x, 8), (y, 1)):
            row.append(float(round(Fraction(value) / Fraction(high, 4)) * Fraction(high, 4)))
        expected.append([*row, z])
    np.testing.assert_array_equal(rounded, expected)


def test_quantising_twice_is_quantising_once():
    once = ATTACKS["quantisation"](MODEL, 9, RNG)
    np.testing.assert_allclose(
        ATTACKS["quantisation"](once, 9, RNG).vertices, once.vertices, rtol=0, atol=1e-15
    )


def test_float32_is_the_nearest_single():
    rounded = ATTACKS["float32"](MODEL, 1, RNG).vertices
    np.testing.assert_array_equal(rounded, rounded.astype(np.float32))
    gap = np.spacing(np.abs(rounded).astype(np.float32)).astype(np.float64)
    assert (np.abs(rounded - MODEL.vertices) <= gap / 2).all()


def test_float32_refuses_what_singles_cannot_hold():
    with pytest.raises(InputError, match=r"beyond the range of 32-bit floats, expected at most 3\.4e38"):
        ATTACKS["float32"](Mesh([[1e39, 0, 0]], np.empty((0, 3))), 1, RNG)
