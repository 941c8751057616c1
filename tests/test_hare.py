"""The model that comes with meshmark, and how it is packed."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from meshmark.data import hare_ply
from meshmark.data.packing import packed, unpacked
from tests.shapes import pebble

# Recorded when the hare was made; its marks in the README's tour are of these bytes.
DIGEST = "b5afcf26c364242c3125be610c74220b6fe1b41823e9a8315af1dd434c7ae1bf"
STEP = 2.0**-10


def model():
    """A pebble on the grid whose points are in any order."""
    positions, faces = pebble(24)
    shuffle = np.random.default_rng(1).permutation(len(positions))
    points = np.empty(positions.shape, np.float32)
    points[shuffle] = np.rint(positions / STEP) * STEP + 0.0  # no negative zeros, which no grid has
    colours = np.random.default_rng(2).integers(0, 256, positions.shape, np.uint8)
    return points, shuffle[faces].astype(np.int32), colours


def corners(points, faces, colours):
    """Return places and colours of the corners of each face, from the first in order on."""
    each = [
        [(*place, *colour) for place, colour in zip(points[row], colours[row], strict=True)] for row in faces
    ]
    return sorted(min(row[k:] + row[:k] for k in range(3)) for row in each)


def test_the_hare_is_the_one_that_was_made():
    assert hashlib.sha256(hare_ply()).hexdigest() == DIGEST


def test_what_is_packed_comes_back_to_the_bit_in_another_order():
    given = model()
    content = packed(*given, STEP)
    back = unpacked(content)
    assert [(array.shape, array.dtype) for array in back] == [(array.shape, array.dtype) for array in given]
    assert corners(*back) == corners(*given)
    assert len(content) < sum(array.nbytes for array in given) / 2


def test_a_mesh_that_would_come_back_changed_is_refused():
    points, faces, colours = model()
    with pytest.raises(ValueError, match="expected steps of"):
        packed(points + np.float32(STEP / 3) * (points > 0.5), faces, colours, STEP)
