"""A lopsided shape and its landmarks, for tests of registration."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.geometry.registration.landmarks import Landmarks
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.similarity import Similarity
from meshmark.mesh import FloatArray, IntArray
from tests.shapes import pebble


def lump(across: int = 72) -> tuple[FloatArray, IntArray]:
    """A pebble with three knobs and a hollow: no two parts are alike."""
    points, faces = pebble(across)
    unit = points / np.linalg.norm(points, axis=1)[:, None]
    out = np.ones(len(points))
    for toward, width, height in (
        ((1.0, 0.6, 0.1), 0.30, 0.45),
        ((-0.3, 1.0, 0.5), 0.35, 0.30),
        ((-0.8, -0.5, 0.6), 0.25, 0.40),
        ((0.2, -0.9, -0.5), 0.40, -0.30),
    ):
        axis = np.array(toward) / np.linalg.norm(toward)
        out += height * np.exp(-np.square(unit - axis).sum(axis=1) / (2.0 * width**2))
    return points * out[:, None], faces


@cache
def reference() -> tuple[Landmarks, Frame]:
    """Landmarks of the lump and its frame."""
    points, faces = lump()
    frame = canonical_frame(points, faces)
    return PreparedSurface(points, faces, frame).landmarks(250), frame


def any_similarity(seed: int) -> Similarity:
    """A random rotation, a scale of 0.1 to 10, a shift of a few sizes."""
    rng = np.random.default_rng(seed)
    turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    return Similarity(
        scale=float(10.0 ** rng.uniform(-1.0, 1.0)), rotation=turn, shift=4.0 * rng.normal(size=3)
    )


def in_scene(frame: Frame) -> Similarity:
    """The way from canonical coordinates to the scene."""
    return Similarity(scale=frame.scale, rotation=frame.axes, shift=frame.centre)


def distance(one: Similarity, other: Similarity, places: FloatArray) -> float:
    """RMS distance between two poses of some places, in units of the second one's scale."""
    return float(np.sqrt(np.square(one(places) - other(places)).sum(axis=1).mean()) / other.scale)
