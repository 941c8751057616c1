from __future__ import annotations

import numpy as np

from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.frame import canonical_frame
from meshmark.ownership.bumps import frame_gradient, frame_values
from tests.shapes import pebble


def test_frame_gradient_predicts_the_moments_of_a_displaced_surface():
    points, faces = pebble(16)
    points = canonical_frame(points, faces).to_canonical(points)
    normals = vertex_normals(points, faces)
    for waves in (1.0, 3.0):
        lengths = 1e-7 * np.sin(waves * points @ [1.0, 0.7, -0.4] + 0.3)
        moved = frame_values(points + lengths[:, None] * normals, faces)
        change = moved - frame_values(points, faces)
        predicted = frame_gradient(points, faces, normals) @ lengths
        assert np.abs(predicted - change).max() < 1e-4 * np.abs(change).max()
