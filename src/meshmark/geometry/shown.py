"""A surface of which a scene shows parts several times: each stored point once, or each showing in its place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.surface import Surface
from meshmark.mesh import IntArray

__all__ = ["Shown", "times_of"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Shown(Surface):
    """A surface with copies.

    times: (p,) how many places of the scene show each point. original: (p,) the point that each is a copy of,
    itself where it is none.
    """

    times: IntArray
    original: IntArray


def times_of(surface: Surface) -> IntArray:
    """Return (p,): how many places of the scene show each point, one where nothing is said of it."""
    return surface.times if isinstance(surface, Shown) else np.ones(len(surface.points), np.int64)
