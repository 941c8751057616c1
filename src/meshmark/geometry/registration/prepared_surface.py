"""A surface prepared for registration: smoothed a little, cut into small pieces, spots with descriptors."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from weakref import WeakKeyDictionary

from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.geometry.registration.agreement import judge
from meshmark.geometry.registration.descriptors import describe
from meshmark.geometry.registration.landmarks import RADIUS, WIDTH, Landmarks, make_landmarks, spread
from meshmark.geometry.registration.pose_candidates import Spots
from meshmark.geometry.registration.surfels import Surfels, low_passed, make_surfels
from meshmark.geometry.registration.windows import look
from meshmark.geometry.similarity import Similarity
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray

__all__ = ["PreparedSurface", "prepared_suspect"]

# All lengths in units of the frame's scale. The low pass takes off what noise adds and keeps what windows see.
LOW_PASS = 0.03
FINE, COARSE = 0.035, 0.06
# Number of places that are matched with landmarks, and of pieces by which a pose is judged.
SPOTS = 800
JUDGES = 300
# A surface that its own landmarks explain less than this is judged as if they explained so much.
LEAST_EXPLAINED = 0.3


# For as long as the surface exists.
_PREPARED: WeakKeyDictionary[Surface, PreparedSurface] = WeakKeyDictionary()


def prepared_suspect(surface: Surface) -> PreparedSurface:
    """Return a surface prepared for registration, the same object each time it is asked for."""
    if surface not in _PREPARED:
        _PREPARED[surface] = PreparedSurface(surface.points, surface.faces)
    return _PREPARED[surface]


class PreparedSurface:
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
        self._described: dict[float, Spots] = {}

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
        """Return up to `count` landmarks of this surface, which may be none."""
        marks = make_landmarks(self.fine, self.coarse, count)
        if not len(marks):
            return marks
        explains = judge(marks, self.coarse, self.judges, Similarity.identity())[1]
        return replace(marks, explains=max(explains, LEAST_EXPLAINED))

    def described(self, scale: float) -> Spots:
        """Return the spots with descriptors of balls as large as those of a reference of this scale.

        Each scale is computed once: a suspect is registered with several references.
        """
        if scale not in self._described:
            places, normals = self.spots
            descriptors = describe(self.coarse, places, normals, RADIUS * scale)
            self._described[scale] = Spots(places=places, normals=normals, descriptors=descriptors)
        return self._described[scale]

    @cached_property
    def judges(self) -> Surfels:
        """A part of the pieces, spread over the surface."""
        return self.coarse.take(spread(self.coarse, JUDGES, 0.1))
