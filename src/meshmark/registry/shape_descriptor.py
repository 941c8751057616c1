"""A descriptor of a shape that its parts have a share of, wherever they lie and however large they are.

1. Places spread over the surface, each weighed by the surface around it, so that neither triangles nor the area
   that noise adds count: 1 / (places within `NEAR`).
2. Around some of them three balls, with radii in a fixed ratio: how much surface is within, how far its middle is
   from the ball's, and how thick it is in its second and third direction (roots of the covariance's eigenvalues),
   all over the radius: 12 numbers, integrals over pieces of the surface.
3. A vocabulary of such numbers, the same for all (`shape_words`); each place counts for the words next to its own.
   The descriptor is the area that each word has, in units of the shape's size (RMS distance from the centroid)
   squared.

A part has the words of the whole, with less area each; but its size is another. So a suspect is described for each
of several sizes (`SIZES`), and `containment` takes the one that fits best. docs/decisions/0025-registry.md has the
figures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.areas import face_areas
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray
from meshmark.registry.shape_words import DEVIATIONS, MEANS, WORDS, words

SingleArray = NDArray[np.float32]

__all__ = ["RATIO", "Shapes", "containment", "described", "described_at_sizes", "shapes_of"]

PLACES: Final = 3000
"""Places that stand for the surface; `CENTRES` of them, about, have balls around them."""
CENTRES: Final = 600
NEAR: Final = 0.12
"""Radius, in sizes, within which sheets are one surface."""
RATIO: Final = 1.2
"""Between two radii, and between two sizes that are tried."""
FIRST: Final = 0.18
"""Smallest radius, in sizes."""
BALLS: Final = (0, 3, 6)
"""Powers of the ratio by which the three radii are larger than the first."""
SIZES: Final = (-1, 0, 1, 2, 3, 4)
"""Powers of the ratio by which the whole may be larger than the suspect."""
OF_PART: Final = 0.9
"""Weight of the part's area in what a match is measured against; the rest is the whole's."""

_HEADER = np.dtype([("version", "u1"), ("unit", "<f4")])
_VERSION = 1
# A place counts for this many words, by distances in deviations, beyond the nearest, of this size.
_NEIGHBOURS, _SOFTNESS = 3, 0.3
# Irrational steps that spread places within triangles (the plastic number's powers).
_STEPS = 0.7548776662466927, 0.5698402909980532
# Rows that are compared at a time: 2 MB, which stay in the processor's cache.
_BLOCK = 1024


def described(surface: Surface) -> bytes:
    """Return the descriptor of a shape: 5 bytes of head and `WORDS` bytes, areas in units that the head tells.

    Raises `InputError` where there is no surface.
    """
    areas = _Pieces(surface).histogram(0)
    unit = float(areas.max()) / 255.0
    head = np.array((_VERSION, unit), _HEADER).tobytes()
    return head + np.round(areas / unit).astype("u1").tobytes()


def described_at_sizes(surface: Surface) -> FloatArray:
    """Return the areas of words (s, `WORDS`) of a suspect, were it part of a shape of each of the sizes.

    Raises `InputError` where there is no surface.
    """
    pieces = _Pieces(surface)
    return np.array([pieces.histogram(power) for power in SIZES], np.float64)


@dataclass(frozen=True, eq=False)
class Shapes:
    """Stored descriptors of n shapes: areas (n, `WORDS`) as small integers, in units (n,) of a suspect's areas."""

    areas: NDArray[np.uint8]
    units: SingleArray


def shapes_of(descriptors: Sequence[bytes | None]) -> Shapes:
    """Return stored descriptors to compare with; those of None and of another version are of no area."""
    size = _HEADER.itemsize + WORDS
    blank = bytes(size)
    known = [
        one if one is not None and len(one) == size and one[0] == _VERSION else blank for one in descriptors
    ]
    rows = np.frombuffer(b"".join(known), np.uint8).reshape(len(known), size)
    units = np.ascontiguousarray(rows[:, 1 : _HEADER.itemsize]).view("<f4")
    return Shapes(rows[:, _HEADER.itemsize :], np.asarray(units[:, 0], np.float32))


def containment(known: Shapes, suspect: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how much of a suspect is contained in each of n shapes, and how much larger the shape then is.

    suspect: (s, `WORDS`), as `described_at_sizes` returns it; the row that fits best counts.
    Returns (n,) from 0 to 1, and (n,) sizes over the suspect's.
    """
    wanted = suspect.astype(np.float32)
    of_part, count = wanted.sum(axis=1), len(known.units)
    best, sizes = np.zeros(count), np.ones(count)
    ones, powers = np.ones(WORDS, np.float32), RATIO ** np.array(SIZES, np.float64)
    for start in range(0, count, _BLOCK):
        part = slice(start, start + _BLOCK)
        rows = known.areas[part] * known.units[part, None]
        whole, smaller = rows @ ones, np.empty_like(rows)
        scores = np.zeros((len(wanted), len(rows)), np.float32)
        for size, one in enumerate(wanted):
            np.minimum(rows, one, out=smaller)
            scores[size] = (smaller @ ones) / (OF_PART * of_part[size] + (1.0 - OF_PART) * whole)
        best[part] = scores.max(axis=0)
        sizes[part] = powers[scores.argmax(axis=0)]
    return best, sizes


class _Pieces:
    """Places of a surface, in units of its size, and what lies around some of them."""

    def __init__(self, surface: Surface) -> None:
        places, weights = _spread(surface)
        total = np.cumsum(weights)
        chosen = np.searchsorted(total, (np.arange(CENTRES) + 0.5) / CENTRES * total[-1])
        self.places, self.centres = places, places[chosen]
        self.squares = _squared_distances(self.centres, places)
        x, y, z = places.T
        moments = np.stack([np.ones(len(x)), x, y, z, x * x, y * y, z * z, x * y, x * z, y * z], axis=1)
        self.moments = (weights[:, None] * moments).astype(np.float32)
        self.area = float(weights.sum()) * np.pi * NEAR**2

    def histogram(self, power: int) -> FloatArray:
        """Return the area of each word (`WORDS`,), were the shape's size `RATIO` to this power times its own."""
        numbers = np.concatenate([self._numbers(FIRST * RATIO ** (ball + power)) for ball in BALLS], axis=1)
        scaled = (numbers - MEANS) / DEVIATIONS
        distance, word = map(np.asarray, kd_tree(words()).query(scaled, _NEIGHBOURS))
        share = np.exp(-0.5 * (distance / (distance[:, :1] + _SOFTNESS)) ** 2)
        share /= share.sum(axis=1, keepdims=True)
        counts = np.bincount(word.ravel(), share.ravel(), WORDS).astype(np.float64)
        return counts * (self.area / RATIO ** (2 * power) / len(scaled))

    def _numbers(self, radius: float) -> FloatArray:
        """Return (c, 4) what lies in the balls of one radius."""
        sums = ((self.squares < radius**2).astype(np.float32) @ self.moments).astype(np.float64)
        mass = np.maximum(sums[:, 0], 1e-9)
        middle = sums[:, 1:4] / mass[:, None]
        spread = np.empty((len(mass), 3, 3))
        for column, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)), start=4):
            spread[:, i, j] = spread[:, j, i] = sums[:, column] / mass - middle[:, i] * middle[:, j]
        thickness = np.sqrt(np.maximum(np.linalg.eigvalsh(spread), 0.0)) / radius
        offset = np.sqrt(((middle - self.centres) ** 2).sum(axis=1)) / radius
        return np.column_stack([np.sqrt(mass) * NEAR / radius, offset, thickness[:, 1], thickness[:, 0]])


def _spread(surface: Surface) -> tuple[FloatArray, FloatArray]:
    """Return places (q, 3) and their weights (q,), the centroid in the origin and the size 1."""
    places = _sampled(surface)
    weights = np.ones(len(places))
    for _ in range(2):  # the size takes the weights, and the weights the size
        places = places - weights @ places / weights.sum()
        places /= np.sqrt(weights @ (places**2).sum(axis=1) / weights.sum())
        near = _squared_distances(places, places) < NEAR**2
        weights = 1.0 / np.maximum(near.sum(axis=1), 1)
    return places, weights


def _sampled(surface: Surface) -> FloatArray:
    """Return places (q, 3) at even intervals of the area of the faces, in their order."""
    points = surface.frame.to_canonical(surface.points)
    total = np.cumsum(face_areas(points, surface.faces))
    step = np.arange(PLACES) + 0.5
    face = np.minimum(np.searchsorted(total, step / PLACES * total[-1]), len(total) - 1)
    u, v = np.sqrt((step * _STEPS[0]) % 1.0)[:, None], ((step * _STEPS[1]) % 1.0)[:, None]
    a, b, c = (points[surface.faces[face, corner]] for corner in range(3))
    return np.asarray((1.0 - u) * a + u * (1.0 - v) * b + u * v * c, np.float64)


def _squared_distances(one: FloatArray, other: FloatArray) -> SingleArray:
    a, b = one.astype(np.float32), other.astype(np.float32)
    return np.asarray((a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * (a @ b.T), np.float32)
