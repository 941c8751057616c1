"""Whether two parts of a surface are alike up to a similarity or its mirror image, and by which map.

Parts that have their points in the same order may be stretched against each other, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.affine import Affine
from meshmark.geometry.connected import Parts
from meshmark.geometry.frame import canonical_frame, frame_alternatives
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.similarity import fit_similarity
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Tolerance", "congruence", "fit_affine", "matched"]

_MIRROR = np.diag([-1.0, 1.0, 1.0])
# Frames bring parts so near to each other, in sizes, that nearest points are each other's.
_ROUGH = 0.05
# Moments over size squared of parts that are alike up to a similarity differ by less than this.
_ALIKE = 1e-3
# Parts whose least second moment is a smaller share than this are flat: many a map takes them onto each other.
_FLAT = 1e-3
# Parts of fewer points are only compared point by point in their order.
_FRAMED = 64


@dataclass(frozen=True)
class Tolerance:
    """How far points of two copies may lie apart: a share of the part's size, and of the largest coordinate."""

    of_size: float
    of_largest: float

    def __call__(self, points: FloatArray, size: FloatArray) -> FloatArray:
        """Return it in scene units for parts of these sizes (n,) among points (p, 3)."""
        return np.asarray(self.of_size * size + self.of_largest * float(np.abs(points).max()))


def congruence(
    points: FloatArray, parts: Parts, ends: tuple[int, int], tolerance: Tolerance
) -> Affine | None:
    """Return the map of the first of two parts to the second, None where they are not alike.

    Points in the same order are compared first, then the parts in their canonical frames.
    """
    one, other = (points[parts.points(end)] for end in ends)
    most = float(tolerance(points, parts.size[[ends[1]]])[0])
    alike = bool(np.abs(np.subtract(*parts.moments[list(ends)])).max() < _ALIKE)
    for affine in _guesses(one, other, (parts, ends), alike):
        if float(np.abs(affine(one) - other).max()) <= most:
            return affine
        if not alike:
            continue
        pairs = _nearest(affine(one), other, max(most, _ROUGH * parts.size[ends[1]]))
        if pairs is not None:
            refined = fit_affine(one[pairs], other)
            if float(np.abs(refined(one[pairs]) - other).max()) <= most:
                return refined
    return None


def matched(
    points: FloatArray, parts: Parts, ends: tuple[int, int], affine: Affine, tolerance: Tolerance
) -> IntArray | None:
    """Return for each point of the second part the one of the first that the map takes there; None: not alike."""
    one, other = affine(points[parts.points(ends[0])]), points[parts.points(ends[1])]
    most = float(tolerance(points, parts.size[[ends[1]]])[0])
    if np.abs(one - other).max() <= most:
        return np.arange(len(one))
    return _nearest(one, other, most)


def fit_affine(source: FloatArray, target: FloatArray, weights: FloatArray | None = None) -> Affine:
    """Return the similarity, or mirrored one, that brings `source` (n, 3) closest to `target` (n, 3)."""
    best, least = Affine.identity(), np.inf
    for turn in (np.eye(3), _MIRROR):
        fit = fit_similarity(source @ turn, target, weights)
        affine = Affine(fit.scale * fit.rotation @ turn, fit.shift)
        off = ((affine(source) - target) ** 2).sum(axis=1)
        left = float(off.sum() if weights is None else weights @ off)
        if left < least:
            best, least = affine, left
    return best


def _guesses(
    one: FloatArray, other: FloatArray, where: tuple[Parts, tuple[int, int]], alike: bool
) -> Iterator[Affine]:
    parts, ends = where
    try:
        if alike:
            yield fit_affine(one, other)
        if len(one) < _FRAMED:
            return
        if parts.moments[ends[0], 0] > _FLAT:
            linear, offset = np.split(np.linalg.lstsq(np.c_[one, np.ones(len(one))], other)[0], [3])
            yield Affine(np.ascontiguousarray(linear.T), offset[0])
        if not alike:
            return
        target = canonical_frame(other, parts.faces(ends[1]))
        for turn in (np.eye(3), _MIRROR):
            source = canonical_frame(one @ turn, parts.faces(ends[0]))
            for frame in frame_alternatives(target):
                linear = frame.axes @ source.axes.T * (frame.scale / source.scale) @ turn
                yield Affine(linear, frame.centre - linear @ turn @ source.centre)
    except InputError:  # a part without extent or surface is no copy of anything
        return


def _nearest(one: FloatArray, other: FloatArray, most: float) -> IntArray | None:
    """Return (n,): the point of `one` next to each of `other`, None where they do not pair off within `most`."""
    off, found = (np.asarray(item) for item in kd_tree(one).query(other))
    if off.max() > most or len(np.unique(found)) < len(other):
        return None
    return found.astype(np.int64)
