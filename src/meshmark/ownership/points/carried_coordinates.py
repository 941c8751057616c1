"""The coordinates of a surface's points that may carry, as embedding and extraction both find them."""

from __future__ import annotations

from copy import copy
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.frame import Frame
from meshmark.geometry.stars import Stars, are_midpoints, stars_of
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray
from meshmark.ownership.points.coordinates import chosen_coordinates
from meshmark.ownership.points.parameters import MODES, ROOM

__all__ = ["Carried"]

# Distance of a midpoint from the middle, in units of the canonical scale.
MIDDLE = 1e-5
# A surface with more midpoints than this share may have been subdivided.
SUBDIVIDED = 0.5


class Carried:
    """What embedding and extraction compute of a surface in a frame.

    frame: that canonical coordinates are of. stars: in these.
    """

    def __init__(self, surface: Surface, frame: Frame) -> None:
        self.frame = frame
        self._points, self._edges = frame.to_canonical(surface.points), surface.edges
        self.stars: Stars = stars_of(self._points, surface.faces)
        self._height, self._usable = self.stars.height, self.stars.used

    def before_subdivision(self) -> Carried | None:
        """Return the same without the points that a subdivision may have added, None where there was none.

        A subdivision at the middles of the edges leaves a quarter of the points, and halves the heights of the
        triangles.
        """
        if not self._usable.any():
            return None
        added = are_midpoints(self._points, self._edges, MIDDLE)
        share = float(added[self._usable].mean())
        if share < SUBDIVIDED:
            return None
        before = copy(self)
        before._height = self._height * 2.0 ** round(np.log(1.0 / (1.0 - min(share, 0.999))) / np.log(4.0))
        before._usable = self._usable & ~added
        return before

    def in_frame(self, frame: Frame) -> FloatArray:
        """Return the points (p, 3) in another turn of the frame."""
        return np.asarray(self._points @ (self.frame.axes.T @ frame.axes))

    def at(self, step: float) -> NDArray[np.bool_]:
        """Return (p,): the points whose stars have room for a step in canonical units."""
        return np.asarray(self._usable & (self._height > ROOM * step))

    @cached_property
    def coordinates(self) -> tuple[NDArray[np.bool_], ...]:
        """(p, 3) for each of `MODES`: the coordinates that carry where there is room."""
        return tuple(chosen_coordinates(self.stars.tensor, mode) for mode in MODES)

    def turned(self, axes: FloatArray) -> tuple[NDArray[np.bool_], ...]:
        """Return `coordinates` along other axes (3, 3), the columns in canonical coordinates."""
        order = np.abs(axes).argmax(axis=0)
        if np.allclose(np.abs(axes), np.eye(3)[:, order], atol=1e-9) and (order == np.arange(3)).all():
            return self.coordinates
        tensor = np.einsum("ji,pjk,kl->pil", axes, self.stars.tensor, axes)
        return tuple(chosen_coordinates(tensor, mode) for mode in MODES)
