"""glTF says that y is up, 3MF and STL that z is; of other formats the shape decides."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.view import from_behind, level_view, three_quarter_view
from meshmark.io import read_mesh, write_mesh
from meshmark.mesh import Mesh
from meshmark.scene.stance import STANCES, stance_of
from tests.shapes import pebble


@pytest.mark.parametrize(("suffix", "up"), [("glb", 1), ("stl", 2), ("3mf", 2), ("ply", None)])
def test_the_format_says_which_way_is_up(tmp_path, suffix, up):
    path = tmp_path / f"pebble.{suffix}"
    write_mesh(Mesh(*pebble(20)), path)
    stance = stance_of(read_mesh(path))
    assert (None if stance is None else int(np.argmax(stance.up))) == up


@pytest.mark.parametrize("format", STANCES)
def test_views_are_rotations_that_look_at_the_front(format):
    stance = STANCES[format]
    level, view = (way(np.zeros((1, 3)), stance) for way in (level_view, three_quarter_view))
    for turn in (level, view, from_behind(view)):
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1.0)
    assert view[2] @ stance.front > 0.75
    assert from_behind(view)[2] @ stance.front < -0.75
    assert view[1] @ stance.up > 0.9
