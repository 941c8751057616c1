"""Where points go so that their coordinates say their bits: the nearest places on the quantiser's points."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.polar import Bits
from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.points.parameters import GUARD, SIDE
from meshmark.ownership.points.point_lattice import PointKeys, PointLattice

__all__ = ["Message", "Quantiser", "Word", "nearest_places"]

# Steps beside the nearest point that are tried for each coordinate, where that one lies outside of the cube.
BESIDE = np.array(list(product((0, -1, 1), repeat=3)))
# Those that differ in the coordinates that are set, by a bit for each of these: others change nothing.
_BESIDE = [
    BESIDE[~(BESIDE[:, ~np.array(kind)] != 0).any(axis=1)] for kind in product((False, True), repeat=3)
]
# Points whose places are tried at once.
ROWS = 1 << 12
# The cube that a point lies in, and those across its nearest sides.
ACROSS = np.array(list(product((0, 1), repeat=3)))


class Message(Protocol):
    """What coordinates say."""

    def bits(self, keys: PointKeys) -> NDArray[np.integer[Any]]:
        """Return the bits (n, 3) of the coordinates that the key says this of."""


@dataclass(frozen=True, eq=False)
class Word:
    """One code word (LENGTH,), which all coordinates carry."""

    word: Bits

    def bits(self, keys: PointKeys) -> Bits:
        """Return the bits (n, 3) of the coordinates that the key says this of."""
        return self.word[keys.code_index]


@dataclass(frozen=True, eq=False, kw_only=True)
class Quantiser:
    """Where coordinates go: to what they are to say, as the lattice tells; step: in canonical units."""

    lattice: PointLattice
    message: Message
    step: float

    def off(self, aims: FloatArray, cubes: IntArray) -> FloatArray:
        """Return how far (n, 3), in steps, the nearest points of the quantiser are from aims in these cubes."""
        keys = self.lattice.keys(cubes)
        off = aims / self.step - keys.dither - self.message.bits(keys) / 2.0
        return np.asarray(np.round(off) - off)


def nearest_places(
    points: FloatArray, follow: FloatArray, quantiser: Quantiser, aims: FloatArray | None = None
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the motions (n, 3) that set the carried coordinates of points, and which points (n,) could be set.

    A point has to stay inside the cube that its bits come from, clear of the sides; where the nearest place is not,
    others are tried, then those of the cubes next to it.

    Parameters
    ----------
    points : (n, 3) float array
        Canonical.
    follow : (n, 3, 3) float array
        Motion of a point for a change of its coordinates, as of `held`.
    quantiser : Quantiser
    aims : (n, 3) float array, optional
        Canonical places from which the nearest places are told, those of the points themselves where left out.
        Copies that were moved differently then go to the same places where their bits are the same.
    """
    motion = np.zeros_like(points)
    done = np.zeros(len(points), bool)
    aims = points if aims is None else aims
    places = quantiser.lattice.places(aims)
    own = np.floor(places).astype(np.int64)
    beyond = np.where(places - own < 0.5, -1, 1)
    followed = follow.any(axis=1) @ np.array([4, 2, 1])  # a bit for each coordinate that is set
    for across in ACROSS:
        left = np.flatnonzero(~done)
        if not len(left):
            break
        cubes = own[left] + across * beyond[left]
        off = quantiser.off(aims[left], cubes)
        for kind, beside in enumerate(_BESIDE):
            some = np.flatnonzero(followed[left] == kind)
            for part in blocks(len(some), ROWS):
                chosen = some[part]
                rows = left[chosen]
                found, fits = _within(
                    points[rows],
                    aims[rows],
                    follow[rows],
                    cubes=cubes[chosen],
                    change=quantiser.step * (off[chosen, None] + beside),
                    quantiser=quantiser,
                )
                motion[rows[fits]] = found[fits]
                done[rows[fits]] = True
    return motion, done


def _within(
    points: FloatArray,
    aims: FloatArray,
    follow: FloatArray,
    *,
    cubes: IntArray,
    change: FloatArray,
    quantiser: Quantiser,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return motions (n, 3) that end well inside these cubes (n, 3), and for which there is one.

    Of those the one whose end is nearest to the aim. change: (n, k, 3) of the aims' coordinates that are tried.
    """
    turn = follow.transpose(0, 2, 1)
    motions = change @ turn
    length = np.einsum("nkj,nkj->nk", motions, motions)
    motions = motions + ((aims - points)[:, None] @ turn)
    ends = quantiser.lattice.places((points[:, None] + motions).reshape(-1, 3)).reshape(motions.shape)
    ends -= cubes[:, None]
    margin = GUARD * quantiser.step / SIDE
    inside = ((ends > margin) & (ends < 1.0 - margin)).all(axis=2)
    length = np.where(inside, length, np.inf)
    best = length.argmin(axis=1)
    rows = np.arange(len(points))
    return motions[rows, best], np.isfinite(length[rows, best])
