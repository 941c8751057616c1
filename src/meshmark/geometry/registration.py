"""Registration: how the reference lies in a suspect that was noised, simplified, cut, turned, moved and rescaled.

Cheap guesses come first (the suspect was not moved; its canonical frame), the search by descriptors only where
none of them holds. Every candidate is refined and judged the same way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from meshmark.geometry.descriptors import describe
from meshmark.geometry.frame import Frame, canonical_frame, frame_alternatives
from meshmark.geometry.judging import judge
from meshmark.geometry.landmarks import RADIUS, WIDTH, Landmarks, make_landmarks, spread
from meshmark.geometry.matching import Spots, candidate_poses
from meshmark.geometry.refine import approach, settle
from meshmark.geometry.similarity import Similarity
from meshmark.geometry.surfels import Surfels, low_passed, make_surfels
from meshmark.geometry.windows import look
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Registered", "Surface", "register"]

LOW_PASS = 0.03
FINE, COARSE = 0.025, 0.06
SPOTS = 800
JUDGES = 600
KEPT = 5
FEWEST = 20
GOOD = 0.8
ROUGH = 0.1
APPROACHED, SETTLED = 12, 3
MOST_DOUBT = 0.02
SCALES = (1.0, 1.2, 1.44, 1.73, 2.07, 0.83)
SCALES_FROM, SCALES_TO = 0.4, 4.0
SAME_SCALE = 0.05


@dataclass(frozen=True, eq=False)
class Registered:
    """A pose (reference's canonical coordinates -> suspect's scene) and how good it is.

    quality: 0 to 1, `explained` times the root of `share`.
    share:     of the landmarks that find their place on the suspect.
    explained: of the suspect's surface that lies where the landmarks say.
    rms:       what is left between landmarks and surface, in units of the reference's scale.
    doubt:     expected error along the weakest direction, in the same unit.
    """

    pose: Similarity
    quality: float
    share: float
    explained: float
    rms: float
    doubt: float


class Surface:
    """A low-passed surface prepared for registration, in canonical coordinates; `frame` leads there.

    frame: by default that of the low-passed surface, which noise moves less.
    Raises `InputError` where there is no surface.
    """

    def __init__(self, points: FloatArray, faces: IntArray, frame: Frame | None = None) -> None:
        unit = (frame or canonical_frame(points, faces)).scale
        smooth = low_passed(points, faces, LOW_PASS * unit)
        self.frame: Frame = frame or canonical_frame(smooth, faces)
        canonical = self.frame.to_canonical(smooth)
        self.fine: Surfels = make_surfels(canonical, faces, FINE)
        self.coarse: Surfels = make_surfels(canonical, faces, COARSE)

    @cached_property
    def spots(self) -> tuple[FloatArray, FloatArray]:
        """Places and normals spread over the surface where descriptors are taken."""
        rows = spread(self.coarse, SPOTS, 0.1)
        places, normals = self.coarse.places[rows], self.coarse.normals[rows]
        for _ in range(2):
            seen = look(self.coarse, places, normals, WIDTH)
            normals = seen.facing
        return places + seen.heights[:, None] * normals, normals

    def landmarks(self, count: int) -> Landmarks:
        """Return up to `count` landmarks of this surface."""
        return make_landmarks(self.fine, self.coarse, count)

    def described(self, scale: float) -> Spots:
        """Return the spots with descriptors of balls as large as those of a reference of this scale."""
        places, normals = self.spots
        return Spots(places, normals, describe(self.coarse, places, normals, RADIUS * scale))

    @cached_property
    def judges(self) -> Surfels:
        """A part of the pieces, spread over the surface."""
        return self.coarse.take(spread(self.coarse, JUDGES, 0.1))


def register(landmarks: Landmarks, home: Frame, surface: Surface) -> list[Registered]:
    """Return the best poses found (canonical coordinates of the reference -> scene of the suspect), best first.

    home: the reference's frame in its own scene. Empty where nothing fits, or where the surface does not
    determine a pose (a plane, a sphere).
    """
    if len(landmarks) < FEWEST or not len(surface.fine):
        return []
    found = _refined(landmarks, surface, list(_guesses(home, surface.frame)))
    if not _good(found):
        for scale in _scales(home, surface.frame):
            poses = candidate_poses(landmarks, surface.described(scale), scale)
            found = _distinct(found + _refined(landmarks, surface, poses))
            if _good(found):
                break
    return [_in_scene(fit, surface.frame) for fit in found[:KEPT]]


def _in_scene(fit: Registered, frame: Frame) -> Registered:
    return replace(fit, pose=_to_scene(frame).after(fit.pose))


def _to_scene(frame: Frame) -> Similarity:
    return Similarity(frame.scale, frame.axes, frame.centre)


def _guesses(home: Frame, frame: Frame) -> Iterator[Similarity]:
    """Yield poses that hold where nothing was moved, and where nothing was cut off."""
    to_own = _to_scene(frame).inverse()
    yield to_own.after(_to_scene(home))
    for other in frame_alternatives(frame, exchange=True):
        yield to_own.after(_to_scene(other))


def _scales(home: Frame, frame: Frame) -> Iterator[float]:
    """Yield scales of the reference in the suspect's coordinates: unit kept, nothing cut off, then a grid."""
    tried: list[float] = []
    for scale in (home.scale / frame.scale, *SCALES):
        if SCALES_FROM < scale < SCALES_TO and all(
            abs(np.log(scale / other)) > SAME_SCALE for other in tried
        ):
            tried.append(scale)
            yield scale


def _refined(landmarks: Landmarks, surface: Surface, poses: list[Similarity]) -> list[Registered]:
    """Return the most promising poses after refinement, best first."""
    first = sorted(
        poses, key=lambda pose: -_quality(*judge(landmarks, surface.coarse, surface.judges, pose, ROUGH))
    )
    near = [approach(landmarks, surface.coarse, pose) for pose in _apart(first)[:APPROACHED]]
    near.sort(key=lambda pose: -_quality(*judge(landmarks, surface.coarse, surface.judges, pose)))
    fits = []
    for pose in _apart(near)[:SETTLED]:
        fit = settle(landmarks, surface.fine, pose)
        share, explained = judge(landmarks, surface.coarse, surface.judges, fit.pose)
        total = max(float(fit.weights.sum()), 1e-9)
        rms = float(np.sqrt(fit.weights @ fit.heights**2 / total))
        fits.append(Registered(fit.pose, _quality(share, explained), share, explained, rms, fit.doubt))
    sound = [fit for fit in fits if fit.doubt < MOST_DOUBT and SCALES_FROM < fit.pose.scale < SCALES_TO]
    return _distinct(sound)


def _quality(share: float, explained: float) -> float:
    return explained * float(np.sqrt(share))


def _good(found: list[Registered]) -> bool:
    return bool(found) and found[0].explained > GOOD


def _distinct(found: list[Registered]) -> list[Registered]:
    """Return the fits best first, each pose once."""
    kept: list[Registered] = []
    for fit in sorted(found, key=lambda fit: -fit.quality):
        if all(_difference(fit.pose, other.pose) > 0.02 for other in kept):
            kept.append(fit)
    return kept


def _apart(poses: list[Similarity]) -> list[Similarity]:
    kept: list[Similarity] = []
    for pose in poses:
        if all(_difference(pose, other) > 0.1 for other in kept):
            kept.append(pose)
    return kept


def _difference(one: Similarity, other: Similarity) -> float:
    """Return the RMS distance between two poses of a surface of RMS size 1, over their scale."""
    turned = np.linalg.norm(one.scale * one.rotation - other.scale * other.rotation) / np.sqrt(3.0)
    return float(np.hypot(turned, np.linalg.norm(one.shift - other.shift)) / one.scale)
