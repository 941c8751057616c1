"""The coordinates of a surface's points that may carry, as embedding and extraction both find them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.frame import Frame
from meshmark.geometry.stars import Stars, are_midpoints, stars_of
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.points.coordinates import chosen_coordinates, ease_of
from meshmark.ownership.points.parameters import MODES, ROOM, STEPS
from meshmark.ownership.points.point_choice import Choice
from meshmark.ownership.points.point_lattice import PointKeys

__all__ = ["Carried"]

# Distance of a midpoint from the middle, in units of the canonical scale.
MIDDLE = 1e-5
# A surface with more midpoints than this share may have been subdivided.
SUBDIVIDED = 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Carried:
    """What embedding and extraction compute of a surface in a frame.

    frame: that canonical coordinates are of. points: (p, 3) in these; stars: of the points, there. edges: (e, 2).
    height: (p,) of the stars' triangles, canonical; usable: (p,) points that may carry.
    """

    frame: Frame
    points: FloatArray
    edges: IntArray
    stars: Stars
    height: FloatArray
    usable: NDArray[np.bool_]

    @classmethod
    def of(cls, surface: Surface, frame: Frame) -> Carried:
        """Measure the stars of a surface."""
        points = frame.to_canonical(surface.points)
        stars = stars_of(points, surface.faces)
        return cls(
            frame=frame,
            points=points,
            edges=surface.edges,
            stars=stars,
            height=stars.height,
            usable=stars.used,
        )

    def before_subdivision(self) -> Carried | None:
        """Return the same without the points that a subdivision may have added, None where there was none.

        A subdivision at the middles of the edges leaves a quarter of the points, and halves the heights of the
        triangles.
        """
        if not self.usable.any():
            return None
        added = are_midpoints(self.points, self.edges, MIDDLE)
        share = float(added[self.usable].mean())
        if share < SUBDIVIDED:
            return None
        times = round(np.log(1.0 / (1.0 - min(share, 0.999))) / np.log(4.0))
        return replace(self, height=self.height * 2.0**times, usable=self.usable & ~added)

    def in_frame(self, frame: Frame) -> FloatArray:
        """Return the points (p, 3) in another turn of the frame."""
        return np.asarray(self.points @ (self.frame.axes.T @ frame.axes))

    def at(self, step: float) -> NDArray[np.bool_]:
        """Return (p,): the points whose stars have room for a step in canonical units."""
        return np.asarray(self.usable & (self.height > ROOM * step))

    def carrying(self, choice: Choice, keys: PointKeys) -> NDArray[np.bool_]:
        """Return (p, 3): the coordinates that carry under a choice; keys: of the points."""
        (coordinates,) = chosen_coordinates(self.stars.tensor, [MODES[choice.mode]], keys.first, self.ease)
        return choice.carrying(coordinates, self.at(choice.step), keys.draw)

    @cached_property
    def room(self) -> NDArray[np.bool_]:
        """(steps, p): the points with room for each of `STEPS`."""
        return np.array([self.at(step) for step in STEPS])

    @cached_property
    def ease(self) -> FloatArray:
        """(p, 3, 3): `ease_of` the points."""
        return ease_of(self.stars.tensor)

    def turned(
        self, axes: FloatArray, first: IntArray, modes: int = len(MODES)
    ) -> tuple[NDArray[np.bool_], ...]:
        """Return (p, 3) for each of `MODES`: the coordinates that carry where there is room.

        axes: (3, 3) that they are along, the columns in canonical coordinates. first: (p,) of the keys there.
        modes: of how many of the first of `MODES`.
        """
        order = np.abs(axes).argmax(axis=0)
        if np.allclose(np.abs(axes), np.eye(3)[:, order], atol=1e-9) and (order == np.arange(3)).all():
            return chosen_coordinates(self.stars.tensor, MODES[:modes], first, self.ease)
        tensor = np.einsum("ji,pjk,kl->pil", axes, self.stars.tensor, axes)
        return chosen_coordinates(tensor, MODES[:modes], first)
