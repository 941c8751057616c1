"""An original laid onto a suspect: where each of its points is found there (for schemes that are not blind)."""

from __future__ import annotations

import numpy as np

from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.registration.register import register
from meshmark.geometry.similarity import Similarity, fit_similarity
from meshmark.mesh import FloatArray
from meshmark.research.schemes.rivals.host import Host

__all__ = ["differences"]

LANDMARKS = 500
# Rounds of closest points and a fit to them; what lies farther away than this many diagonals was cut off.
ROUNDS, REACH = 5, 0.01


def differences(original: Host, suspect: Host) -> tuple[FloatArray, FloatArray]:
    """Return how far each point (p, 3) of the original has moved, and a weight (p,), 0 for those not found.

    Both in the original's coordinates. With the same faces, points are paired by number; otherwise the original
    is registered, and each of its points paired with the closest point of the suspect's surface. Where it does not
    fit, all weights are 0.
    """
    if original.faces.shape == suspect.faces.shape and (original.faces == suspect.faces).all():
        back = fit_similarity(suspect.points, original.points)
        return back(suspect.points) - original.points, np.ones(len(original.points))
    pose = _pose(original, suspect)
    if pose is None:
        return np.zeros_like(original.points), np.zeros(len(original.points))
    surface = SurfaceIndex(suspect.points, suspect.faces)
    for _ in range(ROUNDS):
        there = surface.nearest(pose(original.points)).points
        gap = np.linalg.norm(there - pose(original.points), axis=1)
        near = gap < REACH * original.diagonal * pose.scale
        if near.sum() < 4:
            return np.zeros_like(original.points), np.zeros(len(original.points))
        pose = fit_similarity(original.points, there, near.astype(float))
    return pose.inverse()(there) - original.points, near.astype(float)


def _pose(original: Host, suspect: Host) -> Similarity | None:
    home = canonical_frame(original.points, original.faces)
    landmarks = PreparedSurface(original.points, original.faces, home).landmarks(LANDMARKS)
    found = register(landmarks, home, PreparedSurface(suspect.points, suspect.faces))
    if not found:
        return None
    to_canonical = Similarity(scale=home.scale, rotation=home.axes, shift=home.centre).inverse()
    return found[0].pose.after(to_canonical)
