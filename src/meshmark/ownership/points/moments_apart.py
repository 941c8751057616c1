"""Second moments that nearly agree, kept apart, so that the axes of a canonical frame hold still."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.frame import Frame
from meshmark.mesh import FloatArray
from meshmark.ownership.points.parameters import MOMENTS_APART

__all__ = ["moments_apart", "stretched"]


def moments_apart(frame: Frame, budget: float) -> FloatArray:
    """Return second moments (3,), falling, that are far enough apart for the axes of a frame to hold still.

    They are those of the frame where these are, of the same sum, 1.

    Parameters
    ----------
    frame : Frame
    budget : float
        RMS displacement that points may be given for it, about, in units of the canonical scale.
    """
    # Stretching by this much moves points by a part of the budget, whatever the model's proportions.
    widths = np.sqrt(0.5 * (frame.moments[:-1] + frame.moments[1:]))
    gaps = np.minimum(MOMENTS_APART[0], MOMENTS_APART[1] * budget * widths)
    moments = frame.moments.copy()
    for _ in range(20):
        for i in range(2):
            short = max(float(gaps[i] - (moments[i] - moments[i + 1])), 0.0)
            moments[i] += short / 2.0
            moments[i + 1] -= short / 2.0
    return np.asarray(moments / moments.sum())


def stretched(points: FloatArray, frame: Frame, moments: FloatArray) -> FloatArray:
    """Return canonical points (p, 3) of a frame, stretched along its axes to about these second moments (3,)."""
    return np.asarray(points * np.sqrt(moments / np.maximum(frame.moments, 1e-12)))
