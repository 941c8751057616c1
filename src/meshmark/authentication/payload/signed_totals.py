"""What was signed off as a whole: how many points and how much surface there were, to find what is missing.

Marks show what was changed where they are. A part of its own that is gone leaves no trace among the others, and one
that was added, of rings too fine for marks, shows none: but then the numbers do not agree.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import InputError
from meshmark.geometry.blocks import blocks
from meshmark.geometry.components import connected_components
from meshmark.geometry.shown import Shown, times_of
from meshmark.geometry.surface import Surface
from meshmark.scene.distinct import Distinct

__all__ = [
    "COPIES",
    "SIZE",
    "Whole",
    "points_distinct",
    "points_shown",
    "unmarked_parts",
    "whole_of",
]

_FORM, _MORE = struct.Struct("<If"), struct.Struct("<I")
SIZE = _FORM.size
"""Bytes of a packed `Whole`."""
COPIES = _MORE.size
"""Further bytes for a model that shows copies."""
# Points that are nearer to each other than this number of errors of a coordinate may become one.
_APART = 20.0


@dataclass(frozen=True, kw_only=True)
class Whole:
    """points: that faces use, 0 where they are not counted; area: in squares of half the diagonal, 0: unknown.

    distinct: of a model that shows copies of a mesh, the points without them, 0 of any other.
    shown: how its file showed something else than the surface (`shown_otherwise.packed_deviations`). once: no two
    of its marks that tell the id have rings that are alike; not among the bytes.
    """

    points: int = 0
    area: float = 0.0
    distinct: int = 0
    shown: bytes = b""
    once: bool = False

    @property
    def more(self) -> int:
        """Return how many bytes more than `SIZE` it has when packed."""
        return (COPIES if self.distinct else 0) + (1 + len(self.shown) if self.shown else 0)

    def packed(self) -> bytes:
        """Return `SIZE` bytes, `COPIES` more of a model that shows copies, then the length and bytes of `shown`."""
        copies = _MORE.pack(self.distinct) if self.distinct else b""
        shown = bytes([len(self.shown)]) + self.shown if self.shown else b""
        return _FORM.pack(self.points, self.area) + copies + shown

    @staticmethod
    def read(packed: bytes, *, copies: bool, shown: bool, once: bool) -> tuple[Whole, bytes]:
        """Undo `packed`; copies, shown: whether it has these. Returns what follows as well.

        Raises `InputError` where there are too few bytes.
        """
        size = SIZE + (COPIES if copies else 0)
        length = packed[size] if shown and len(packed) > size else 0
        end = size + (1 + length if shown else 0)
        if len(packed) < end:
            raise InputError("the payload ends within its head, expected one that meshmark has made")
        points, area = _FORM.unpack(packed[:SIZE])
        (distinct,) = _MORE.unpack(packed[SIZE:size]) if copies else (0,)
        whole = Whole(
            points=points, area=area, distinct=distinct, shown=packed[end - length : end], once=once
        )
        return whole, packed[end:]


def whole_of(
    surface: Surface, precision: float, scene: Distinct | None = None, *, web: bool = False
) -> Whole:
    """Return the numbers of a surface; points are not counted where rounding may make two of them one.

    scene: of which the surface is that without copies. web: its marks bear a grid of 14 bits; points that such a
    grid makes one are one already, but for a few that marks bring together (`Examination.points_missing`).
    """
    least = 0.0 if web else _APART * precision
    used, apart = surface.used, _apart(surface, least)
    half, areas = 0.5 * surface.diagonal, surface.face_areas
    if scene is None:
        return Whole(points=int(used.sum()) if apart else 0, area=float(areas.sum()) / half**2)
    times = scene.shown(surface)
    area = float(areas @ times[surface.faces[:, 0]])
    points = int(times[used].sum()) if apart else 0
    return Whole(points=points, area=area / half**2, distinct=int(used.sum()))


def _apart(surface: Surface, least: float) -> bool:
    """Return whether all edges are longer than `least`, in scene units."""
    for part in blocks(len(surface.edges)):
        start, end = surface.edges[part].T
        steps = surface.points[start] - surface.points[end]
        if not (np.einsum("ij,ij->i", steps, steps) > least**2).all():
            return False
    return True


def points_shown(surface: Surface) -> int:
    """Return how many points that faces use a scene shows, copies counted."""
    return int(times_of(surface)[surface.used].sum())


def points_distinct(surface: Shown) -> int:
    """Return how many points that faces use are no copies."""
    return int((surface.used & (surface.original == np.arange(len(surface.points)))).sum())


def unmarked_parts(surface: Surface, verified: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (p,): the points of connected parts of which no point is `verified` (p,)."""
    part = connected_components(surface.graph)[1]
    marked = np.zeros(int(part.max(initial=-1)) + 1, bool)
    marked[part[verified]] = True
    return np.asarray(~marked[part] & surface.used)
