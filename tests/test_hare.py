"""The model that comes with meshmark, and how it is packed."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from meshmark.data import hare_ply
from meshmark.data.packing import packed, sorted_faces, unpacked
from tests.shapes import pebble

# Recorded when the hare was made; its marks in the README's tour are of these bytes.
DIGEST = "04c342f5959c8a0c3907c740c03947c404f0a373b793163c5fdd6867424dc42c"
STEP = 2.0**-10


def model():
    """A pebble on the grid whose points are in any order."""
    positions, faces = pebble(24)
    shuffle = np.random.default_rng(1).permutation(len(positions))
    points = np.empty(positions.shape, np.float32)
    points[shuffle] = np.rint(positions / STEP) * STEP + 0.0  # no negative zeros, which no grid has
    colours = np.random.default_rng(2).integers(0, 256, positions.shape, np.uint8)
    return points, sorted_faces(shuffle[faces].astype(np.int32)), colours


def test_the_hare_is_the_one_that_was_made():
    assert hashlib.sha256(hare_ply()).hexdigest() == DIGEST


def test_what_is_packed_comes_back_to_the_bit():
    given = model()
    content = packed(*given, STEP)
    assert [array.tobytes() for array in unpacked(content)] == [array.tobytes() for array in given]
    assert len(content) < sum(array.nbytes for array in given) / 2


def test_a_mesh_that_would_come_back_changed_is_refused():
    points, faces, colours = model()
    with pytest.raises(ValueError, match="expected steps of"):
        packed(points + np.float32(STEP / 3) * (points > 0.5), faces, colours, STEP)
    with pytest.raises(ValueError, match="sorted faces"):
        packed(points, faces[::-1].copy(), colours, STEP)


def test_sorted_faces_are_the_same_faces():
    faces = np.random.default_rng(3).integers(0, 2**31 - 1, (500, 3)).astype(np.int32)
    found = sorted_faces(faces)
    turns = {tuple(row[[k, (k + 1) % 3, (k + 2) % 3]]) for row in faces for k in range(3)}
    assert {tuple(row) for row in found} <= turns
    assert len(found) == 500
    assert np.array_equal(found[:, 0], np.sort(faces.min(axis=1)))
