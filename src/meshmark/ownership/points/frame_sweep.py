"""Frames of a surface with nearly equal moments: its axes turn easily, and many turns are looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from meshmark.geometry.frame import Frame
from meshmark.geometry.similarity import rotation_of
from meshmark.mesh import FloatArray
from meshmark.ownership.parameters import ALIKE
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.parameters import STEPS
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.quick_waves import quick_cosine

__all__ = ["peaks", "sweep"]

# Where moments are alike their axes turn: by so much, in radians, over the gap between them, and at most.
TURNS, MOST = 1e-4, 0.06
# Moments of a marked surface differ by more than this times its width along their axes: an embedding sees to that.
NEVER = 1e-4
# Turns are this far apart, in radians, and judged by this number of points, at steps of at least this index.
APART, JUDGES, COARSE = 6e-4, 250, 6


def sweep(carried: Carried, frame: Frame, lattice: PointLattice) -> list[tuple[float, Frame]]:
    """Return frames about `frame`, turned about the axis that stands out, with how well points lock there.

    In the order of their angles. Empty where the moments are apart, or more alike than an embedding leaves them, or
    nothing has room for a step. A score is of the best step, in standard deviations of chance.

    Parameters
    ----------
    carried : Carried
        Of a surface in a frame with these moments.
    frame : Frame
        One of the alternatives of that frame.
    lattice : PointLattice
    """
    gaps = -np.diff(frame.moments)
    pair = int(np.argmin(gaps))
    rows = np.flatnonzero(carried.at(float(STEPS[COARSE])))
    width = float(np.sqrt(frame.moments[pair : pair + 2].mean()))
    if not NEVER * width <= gaps[pair] <= ALIKE or not len(rows):
        return []
    points = carried.in_frame(frame)[rows]
    draw = lattice.keys(lattice.cubes(points)).draw.min(axis=1)
    points = points[np.argsort(draw, kind="stable")[:JUDGES]]
    count = int(np.ceil(min(TURNS / max(gaps[pair], TURNS / MOST), MOST) / APART))
    angles = APART * np.array([turn for turn in range(-count, count + 1) if turn])
    about = np.eye(3)[2 if pair == 0 else 0]
    turned = [rotation_of(angle * about) for angle in angles]
    placed = np.stack([points @ turn for turn in turned])
    scores = _scores(placed, lattice, [axis for axis in range(3) if not about[axis]])
    return [
        (float(score), replace(frame, axes=np.ascontiguousarray(frame.axes @ turn)))
        for score, turn in zip(scores, turned, strict=True)
    ]


def peaks(swept: list[tuple[float, Frame]]) -> list[tuple[float, Frame]]:
    """Return those frames of a sweep, in its order, whose neighbours score no more."""
    scores = np.array([-np.inf, *(score for score, _ in swept), -np.inf])
    tops = (scores[1:-1] >= scores[:-2]) & (scores[1:-1] >= scores[2:])
    return [swept[row] for row in np.flatnonzero(tops)]


def _scores(placed: FloatArray, lattice: PointLattice, axes: list[int]) -> FloatArray:
    """Return (k,) the best lock of any step of points (k, n, 3), by two coordinates."""
    dither = lattice.keys(lattice.cubes(placed.reshape(-1, 3))).dither.reshape(placed.shape)
    x, at = placed[:, :, axes], dither[:, :, axes]
    sums = [quick_cosine(2.0 * (x / step - at)).sum(axis=(1, 2)) for step in STEPS[COARSE:]]
    return np.asarray(np.max(sums, axis=0) / np.sqrt(x[0].size / 2.0))
