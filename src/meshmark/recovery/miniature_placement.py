"""Where the miniature lies in the suspect: found on the intact part, and fitted to it by tangent planes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.areas import area_vectors
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.frame import Frame, canonical_frame, frame_alternatives
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.registration.register import register
from meshmark.geometry.similarity import Similarity, rotation_of
from meshmark.mesh import FloatArray, IntArray

__all__ = ["place_miniature"]

# Intact points that judge and fit a pose: few at first, then more.
FEW, MANY = 300, 4000
FIRST_ROUNDS, ROUNDS = 4, 12
# A fit this good, in units of the frame's scale, needs no search; with a worse one than this nothing is recovered.
GOOD, WORST = 0.02, 0.08
LANDMARKS = 400


def place_miniature(
    mini: tuple[FloatArray, IntArray], points: FloatArray, faces: IntArray, intact: IntArray
) -> Similarity:
    """Return the similarity from the miniature's coordinates to the scene of the suspect.

    points, faces: of the suspect; intact: (k,) the points to go by. Raises `InputError` where nothing fits.
    """
    if len(intact) < 4:
        raise InputError(f"{len(intact)} points are intact, expected enough to place the miniature by")
    fit = _Fit(mini, points[intact])
    frames = list(_frames(points, faces, intact))
    best = fit.best(_poses(frames))
    if best[0] > GOOD:
        landmarks = PreparedSurface(*mini).landmarks(LANDMARKS)
        home = Frame(
            centre=np.zeros(3), scale=1.0, axes=np.eye(3), moments=frames[0].moments, area=frames[0].area
        )
        found = register(landmarks, home, PreparedSurface(points, _faces_of(faces, intact, len(points))))
        best = min(best, fit.best(entry.pose for entry in found), key=lambda pair: pair[0])
    if not best[0] < WORST:
        raise InputError("the miniature does not fit the intact part, expected one of the same model")
    return fit.refined(best[1])


def _frames(points: FloatArray, faces: IntArray, intact: IntArray) -> Iterator[Frame]:
    """Yield what the canonical frame may have been: the suspect's, and that of its intact faces."""
    for part in (faces, _faces_of(faces, intact, len(points))):
        if len(part):
            yield from frame_alternatives(canonical_frame(points, part), exchange=True)


def _faces_of(faces: IntArray, intact: IntArray, count: int) -> IntArray:
    holds = np.zeros(count, bool)
    holds[intact] = True
    return np.asarray(faces[holds[faces].all(axis=1)])


def _poses(frames: list[Frame]) -> Iterator[Similarity]:
    for frame in frames:
        yield Similarity(scale=frame.scale, rotation=frame.axes, shift=frame.centre)


class _Fit:
    """The miniature's surface and the intact points."""

    def __init__(self, mini: tuple[FloatArray, IntArray], intact: FloatArray) -> None:
        self.index = SurfaceIndex(*mini)
        vectors = area_vectors(*mini)
        length = np.sqrt((vectors**2).sum(axis=1))
        self.normals = vectors / np.where(length > 0.0, length, 1.0)[:, None]
        self.intact = intact

    def best(self, poses: Iterator[Similarity]) -> tuple[float, Similarity]:
        """Return what is left over, and the pose, of the best of some after a few rounds."""
        few = self.intact[:: max(len(self.intact) // FEW, 1)]
        refined = [self._refined(pose, few, FIRST_ROUNDS) for pose in poses]
        return min(refined, key=lambda pair: pair[0], default=(np.inf, Similarity.identity()))

    def refined(self, pose: Similarity) -> Similarity:
        """Return the pose fitted to many points."""
        return self._refined(pose, self.intact[:: max(len(self.intact) // MANY, 1)], ROUNDS)[1]

    def _refined(self, pose: Similarity, scene: FloatArray, rounds: int) -> tuple[float, Similarity]:
        back = pose.inverse()
        for _ in range(rounds):
            places = back(scene)
            nearest = self.index.nearest(places)
            heights = np.einsum("ij,ij->i", nearest.points - places, self.normals[nearest.faces])
            limit = 3.0 * max(float(np.median(nearest.distances)), 1e-6)
            weights = np.clip(1.0 - (nearest.distances / (2.0 * limit)) ** 2, 0.0, 1.0) ** 2
            back = _step(back, places, self.normals[nearest.faces], heights, weights)
        left = self.index.nearest(back(scene)).distances
        return float(np.sqrt(np.mean(np.minimum(left, 4.0 * np.median(left)) ** 2))), back.inverse()


def _step(
    back: Similarity, places: FloatArray, normals: FloatArray, heights: FloatArray, weights: FloatArray
) -> Similarity:
    """Return the pose after one Gauss-Newton step on the heights over the tangent planes."""
    centre = weights @ places / weights.sum()
    arms = places - centre
    along = np.einsum("ij,ij->i", arms, normals)
    jacobian = np.column_stack([normals, np.cross(arms, normals), along])
    normal = jacobian.T @ (jacobian * weights[:, None])
    normal += 1e-6 * np.trace(normal) * np.eye(7)
    move = np.asarray(np.linalg.solve(normal, jacobian.T @ (weights * heights)), np.float64)
    turn, growth = rotation_of(move[3:6]), float(np.exp(np.clip(move[6], -0.3, 0.3)))
    step = Similarity(scale=growth, rotation=turn, shift=centre + move[:3] - growth * (turn @ centre))
    return step.after(back)
