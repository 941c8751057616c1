"""What may have happened to a suspect, undone: noise filtered off, smoothing taken back, a stretch relaxed.

Smoothing by neighbours' means multiplies each frequency x of the mesh by about exp(-t x), t being passes times
strength. It is undone by the inverse, as far as the noise lets it, for a few t; between two of them shapes are
interpolated, and how far is one more part of the correction that the lock finds.
Noise makes the surface rough, its area uneven, and so its frame wrong: rough shapes are low-passed first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from meshmark.geometry.completion import frame_distance
from meshmark.geometry.frame import Frame, canonical_frame, frame_alternatives
from meshmark.geometry.scale_space import spectral_filters
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray

__all__ = ["Restoration", "Shape", "restorations", "stretched"]

# Low-pass filters 1 - (1 - exp(-t x))^4: flat for coarse shape, nothing of the roughness left.
LOW_PASS: Final = (2.0, 4.0)
ORDER: Final = 4
# A shape that filtering leaves smaller than this has no frame for others. Nor has one whose frame is further than
# AGREED (`frame_distance`) from that of a shape low-passed by SMOOTHEST: the filter itself, and not noise, moves
# the frame by more than a lock finds back (decision 0044).
HELD: Final = 0.5
SMOOTHEST, AGREED = 8.0, 0.017
# Shapes whose frames differ by less than this, half a standard deviation, need not be read in both.
SAME_FRAME: Final = 0.006
# Amounts of smoothing undone; from one to the next shapes are interpolated.
UNDONE: Final = (0.0, 0.9, 2.0, 3.6, 5.6)
# The inverse is the series sum_k (1 - exp(-t x))^k up to this k, which bounds what it does to noise.
INVERSE_TERMS: Final = 8
# A stretch is relaxed in all five ways that keep the size, each with this standard deviation.
STRETCH: Final = 0.01
# Unit strains: along two axes, and askew between each two.
STRAINS: Final = (
    np.diag([1.0, -1.0, 0.0]) / np.sqrt(2.0),
    np.diag([1.0, 1.0, -2.0]) / np.sqrt(6.0),
    *(
        np.roll(np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), (k, k), (0, 1)) / np.sqrt(2.0)
        for k in range(3)
    ),
)


@dataclass(frozen=True, eq=False)
class Shape:
    """Positions (p, 3) of a suspect's points as they may have been; equal to itself only.

    framed_by: the shape whose canonical frame it lies in; None: its own.
    """

    points: FloatArray
    framed_by: Shape | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Restoration:
    """One guess at the shape before an attack: `shapes[0]` and so far towards each of the others.

    middle, expected: for each shape after the first, the share of the way that is expected
    and its standard deviation.
    """

    shapes: tuple[Shape, ...]
    middle: tuple[float, ...] = ()
    expected: tuple[float, ...] = ()

    def between(self, shares: Iterable[float]) -> FloatArray:
        """Return points (p, 3): the first shape, and from it these shares of the way to each of the others."""
        first, *others = (shape.points for shape in self.shapes)
        ways = zip(shares, others, strict=True)
        return first + sum((share * (other - first) for share, other in ways), np.zeros_like(first))


def stretched(points: FloatArray) -> Restoration:
    """Return what may have been before a stretch of up to about 2 %, whatever its axes."""
    centre = points.mean(axis=0)
    ends = [points + (points - centre) @ (STRETCH * strain) for strain in STRAINS]
    return Restoration(
        shapes=(Shape(points), *map(Shape, ends)), middle=(0.0,) * len(ends), expected=(1.0,) * len(ends)
    )


def restorations(surface: Surface, frame_known: bool = False) -> Iterator[Restoration]:
    """Yield what may have been before noise or smoothing, likeliest first.

    Low-passed shapes are left out where the filter moves the frame by more than a lock finds back, as on coarse
    meshes. frame_known: the shapes are read in a given frame, whatever their own is.
    """
    yield Restoration(shapes=(Shape(surface.points),))
    filters = [_low_pass(t) for t in (*LOW_PASS, SMOOTHEST)] + [_undone(t) for t in UNDONE[1:]]
    centre = surface.points.mean(axis=0)
    filtered = spectral_filters(surface.walk, surface.points - centre, filters)
    filtered += centre
    smooth, smoother, smoothest, *undone = map(Shape, filtered)
    # Noise makes areas uneven, and by that moves the frame by more than a lock reaches; of the smoothest shape it
    # moves it least, unless the filter itself does.
    holds = _holds(surface.points - centre, smoother.points - centre)
    frame = smoother if holds else None
    low_passed = frame_known
    if holds and not frame_known:
        own, further = (canonical_frame(shape.points, surface.faces) for shape in (smoother, smoothest))
        low_passed = _apart(own, further) < AGREED
        if low_passed and _apart(surface.frame, own) > SAME_FRAME:
            yield Restoration(shapes=(Shape(surface.points, frame),))
    if low_passed:
        yield Restoration(shapes=(Shape(smooth.points, frame),))
    for before, after in pairwise((smooth, *undone)):
        yield Restoration(shapes=(before, after), middle=(0.5,), expected=(0.3,))
    if low_passed:
        yield Restoration(shapes=(smoother,))


def _holds(points: FloatArray, filtered: FloatArray) -> bool:
    """Return whether a filter leaves the size of a shape about as it was; few large triangles shrink to nothing."""
    return float(np.linalg.norm(filtered)) > HELD * float(np.linalg.norm(points))


def _apart(one: Frame, other: Frame) -> float:
    """Return how far two frames are from each other, in the nearest turn of the other."""
    return min(frame_distance(one, turned) for turned in frame_alternatives(other))


def _low_pass(amount: float) -> Callable[[FloatArray], FloatArray]:
    return lambda x: 1.0 - (1.0 - np.exp(-amount * x)) ** ORDER


def _undone(amount: float) -> Callable[[FloatArray], FloatArray]:
    """Return the inverse of smoothing by `amount`, low-passed as shapes without smoothing are."""
    kept = _low_pass(LOW_PASS[0])

    def response(x: FloatArray) -> FloatArray:
        lost = 1.0 - np.exp(-amount * x)
        return np.asarray(kept(x) * sum(lost**k for k in range(INVERSE_TERMS + 1)))

    return response
