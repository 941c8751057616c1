"""Registration: how the reference lies in a suspect that was noised, simplified, cut, turned, moved and rescaled.

Cheap guesses come first (the suspect was not moved; its canonical frame), the search by descriptors only where
none of them convinces. Every candidate is refined and judged the same way.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from meshmark.geometry.frame import Frame, frame_alternatives
from meshmark.geometry.registration.agreement import TOLERANCE, judge
from meshmark.geometry.registration.landmarks import Landmarks
from meshmark.geometry.registration.pose_candidates import candidate_poses
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.registration.refinement import approach, doubt, refine
from meshmark.geometry.registration.surfels import Surfels
from meshmark.geometry.similarity import Similarity

__all__ = ["Registered", "register"]

KEPT = 5
"""Poses returned at most."""
# What is left over, in units of the reference's scale, halves the quality when it is this large.
COMMON_RMS = 0.03
# Fewer landmarks than this determine nothing.
FEWEST = 20
# What explains this share of what it could, with no more than this left over, needs no (further) search; a lower
# share will do after a search where the next best is worse by a margin.
SURE, CLOSE = 0.94, 0.012
LIKELY, MARGIN = 0.75, 0.1
# Poses far below the best, or that explain little, are not returned.
LEAST_EXPLAINED, LEAST_QUALITY = 0.4, 0.6
# Tolerance, in units of the reference's scale, for poses that were not refined yet.
ROUGH = 0.1
# Poses of one search that are moved to the nearest surface, and, of these, the best that are refined.
APPROACHED, REFINED = 10, 3
# A pose is refined if it is judged at least this share of the best.
WORTHWHILE = 0.5
# Poses closer than this are one: before and after refinement, in units of the reference's scale.
NEAR, SAME = 0.1, 0.02
# A pose this uncertain along some direction, in units of the reference's scale, is not determined: by the whole
# reference, and by what is left of it on a suspect, where a coarse answer still helps.
MOST_DOUBT, MOST_DOUBT_LEFT = 0.012, 0.02
# Scales of the reference over the suspect's own: what is left of a cropped model can be much smaller.
SCALES = (1.0, 1.2, 1.45, 1.75, 2.1, 0.85)
SCALES_FROM, SCALES_TO = 0.4, 4.0
SAME_SCALE = 0.05


@dataclass(frozen=True, eq=False, kw_only=True)
class Registered:
    """A pose (reference's canonical coordinates -> suspect's scene) and how good it is.

    quality:   0 to 1, `explained` times the root of `share`, less where `rms` is large.
    share:     of the landmarks that find their place on the suspect, 0 to 1.
    explained: of the suspect's surface that lies where the landmarks say, 0 to 1; 1 is what can be expected.
    rms:       what is left between landmarks and surface, in units of the reference's scale.
    doubt:     expected error along the weakest direction, in the same unit.
    """

    pose: Similarity
    quality: float
    share: float
    explained: float
    rms: float
    doubt: float


def register(
    landmarks: Landmarks, home: Frame, suspect: PreparedSurface, scales: Sequence[float] = ()
) -> list[Registered]:
    """Return the best poses found (canonical coordinates of the reference -> scene of the suspect), best first.

    home: the reference's frame in its own scene. scales: of the reference over the suspect's, where they are known
    about; by default the same unit, the same size, and `SCALES`. Empty where nothing fits, or where the surface
    does not determine a pose (a plane, a sphere).
    """
    if len(landmarks) < FEWEST or not _determined(landmarks, suspect.judges):
        return []
    found = _best_refined(landmarks, suspect, list(_guesses(home, suspect.frame)))
    if not _sure(found):
        for scale in scales or _scales(home, suspect.frame):
            poses = candidate_poses(landmarks, suspect.described(scale), scale)
            found = _distinct(found + _best_refined(landmarks, suspect, poses))
            if _sure(found) or _clear(found):
                break
    to_scene = _to_scene(suspect.frame)
    return [replace(fit, pose=to_scene.after(fit.pose)) for fit in found[:KEPT]]


def _determined(landmarks: Landmarks, judges: Surfels) -> bool:
    whole = doubt(landmarks.places, landmarks.normals)
    return whole < MOST_DOUBT and doubt(judges.places, judges.normals) < MOST_DOUBT_LEFT


def _sure(found: list[Registered]) -> bool:
    return bool(found) and found[0].explained > SURE and found[0].rms < CLOSE


def _clear(found: list[Registered]) -> bool:
    """Whether the best explains much, and clearly more than the next."""
    if not found or found[0].explained < LIKELY:
        return False
    return len(found) == 1 or found[0].quality > found[1].quality + MARGIN


def _to_scene(frame: Frame) -> Similarity:
    return Similarity(scale=frame.scale, rotation=frame.axes, shift=frame.centre)


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


def _best_refined(
    landmarks: Landmarks, suspect: PreparedSurface, poses: list[Similarity]
) -> list[Registered]:
    """Return the most promising poses after refinement, best first."""
    first = [pose for _, pose in _ranked(landmarks, suspect, _apart(poses), ROUGH)]
    near = [approach(landmarks, suspect.coarse, pose) for pose in first[:APPROACHED]]
    ranked = _ranked(landmarks, suspect, _apart(near))
    worth = [pose for quality, pose in ranked[:REFINED] if quality >= WORTHWHILE * ranked[0][0]]
    return _distinct([fit for pose in worth if (fit := _refined(landmarks, suspect, pose)) is not None])


def _refined(landmarks: Landmarks, suspect: PreparedSurface, pose: Similarity) -> Registered | None:
    fit = refine(landmarks, suspect.coarse, suspect.fine, pose)
    if not (fit.doubt < MOST_DOUBT_LEFT and SCALES_FROM < fit.pose.scale < SCALES_TO):
        return None
    share, explained = _judged(landmarks, suspect, fit.pose)
    rms = float(np.sqrt(fit.weights @ fit.heights**2 / fit.weights.sum()))
    quality = _quality(share, explained) / (1.0 + (rms / COMMON_RMS) ** 2)
    return Registered(
        pose=fit.pose, quality=quality, share=share, explained=explained, rms=rms, doubt=fit.doubt
    )


def _ranked(
    landmarks: Landmarks, suspect: PreparedSurface, poses: list[Similarity], tolerance: float = TOLERANCE
) -> list[tuple[float, Similarity]]:
    """Return the poses with their quality, best first."""
    judged = [(_quality(*_judged(landmarks, suspect, pose, tolerance)), pose) for pose in poses]
    return sorted(judged, key=lambda pair: -pair[0])


def _judged(
    landmarks: Landmarks, suspect: PreparedSurface, pose: Similarity, tolerance: float = TOLERANCE
) -> tuple[float, float]:
    share, explained = judge(landmarks, suspect.coarse, suspect.judges, pose, tolerance)
    return share, min(1.0, explained / landmarks.explains)


def _quality(share: float, explained: float) -> float:
    return explained * float(np.sqrt(share))


def _distinct(found: list[Registered]) -> list[Registered]:
    """Return the fits best first, each pose once, without those that are far worse than the best."""
    kept: list[Registered] = []
    for fit in sorted(found, key=lambda fit: -fit.quality):
        good = fit.explained > LEAST_EXPLAINED and (not kept or fit.quality > LEAST_QUALITY * kept[0].quality)
        if good and all(_difference(fit.pose, other.pose) > SAME for other in kept):
            kept.append(fit)
    return kept


def _apart(poses: list[Similarity]) -> list[Similarity]:
    """Return the poses without those that are near an earlier one."""
    kept: list[Similarity] = []
    for pose in poses:
        if all(_difference(pose, other) > NEAR for other in kept):
            kept.append(pose)
    return kept


def _difference(one: Similarity, other: Similarity) -> float:
    """Return the RMS distance between two poses of a surface of RMS size 1, over their scale."""
    turned = np.linalg.norm(one.scale * one.rotation - other.scale * other.rotation) / np.sqrt(3.0)
    return float(np.hypot(turned, np.linalg.norm(one.shift - other.shift)) / one.scale)
