"""What a recovery says where nothing can be given back."""

from __future__ import annotations

import numpy as np

from meshmark.marking import embed, recover
from meshmark.mesh import Mesh
from tests.keys import ID, KEY
from tests.shapes import pebble


def test_a_component_that_cannot_be_moved_back_is_left_and_nothing_is_promised():
    (large, faces), (small, others) = pebble(60), pebble(20)
    points = np.concatenate([large, 0.12 * small + [3.0, 0.0, 0.0]])
    marked = embed(Mesh(points, np.concatenate([faces, others + len(large)])), KEY, id=ID).mesh
    apart = np.arange(len(points)) >= len(large)
    stretched = np.where(apart[:, None], marked.vertices * [1.0, 1.0, 2.5] + [0.0, 0.4, 0.0], marked.vertices)
    found = recover(marked.with_vertices(stretched), KEY)
    assert found.mesh is None
    assert found.advice.startswith("What was altered is a connected component of its own")
