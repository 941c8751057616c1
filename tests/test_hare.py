"""The model that comes with meshmark, and how it is packed."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from meshmark.data import hare_ply
from meshmark.data.packing import packed, unpacked

# Recorded when the hare was made; its marks in the README's tour are of these bytes.
DIGEST = "040c0c169ef09acaf777445eef0509a0e3652b438412dbf41804dda18fbc2a8f"


def test_the_hare_is_the_one_that_was_made():
    assert hashlib.sha256(hare_ply()).hexdigest() == DIGEST


@pytest.mark.parametrize("faces", [0, 1, 500])
def test_what_is_packed_comes_back_to_the_byte(faces):
    rng = np.random.default_rng(faces)
    triangles = np.empty(faces, [("count", "u1"), ("corner", "<i4", 3)])
    triangles["count"], triangles["corner"] = 3, rng.integers(0, 2**31 - 1, (faces, 3))
    ply = b"ply\nanything\n" + rng.bytes(99) + triangles.tobytes()
    assert unpacked(packed(ply, faces)) == ply


def test_faces_in_order_take_less():
    corners = np.arange(30_000, dtype="<i4")
    triangles = np.empty(30_000, [("count", "u1"), ("corner", "<i4", 3)])
    triangles["count"], triangles["corner"] = 3, np.stack([corners, corners + 1, corners + 170], axis=1)
    assert len(packed(triangles.tobytes(), 30_000)) < 2_000
