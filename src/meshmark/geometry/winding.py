"""The winding of faces, made consistent where a file has mixed it up."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array

from meshmark.arrays import AnyIntArray, IntArray
from meshmark.geometry.components import connected_components
from meshmark.geometry.face_neighbours import face_neighbours

__all__ = ["consistent_winding"]

# A component is left as it is where at most this share of the edges between two of its faces joins faces that turn
# against each other: single faces that were turned over are a change, not a way of storing.
_MIXED = 0.1


def consistent_winding(faces: IntArray, count: int) -> IntArray:
    """Return triangles, those turned over that turn against most of their component.

    Components are of faces joined by edges that belong to two faces. One is left as it is where it is nearly
    consistent, where it cannot be wound consistently, as a Moebius strip cannot, and where as many faces turn one
    way as the other.

    Parameters
    ----------
    faces : (m, 3) int array
    count : int
        Number of points.

    Returns
    -------
    (m, 3) int array
        In the same order; the same array where nothing is turned over.
    """
    if not _walked_twice(faces, count):
        return faces
    one, other, against = face_neighbours(faces, count)
    if not against.any():
        return faces
    size = len(faces)
    parts, part = connected_components(_graph(one, other, size))
    mixed = np.bincount(part[one], against, parts) > _MIXED * np.bincount(part[one], minlength=parts)
    # Each face once as it is and once turned over, joined where two turn alike: in two halves, mirror images of
    # each other, unless both ways of a face hang together.
    cover = _graph(
        np.concatenate([one, one + size]),
        np.concatenate([other + size * against, other + size * ~against]),
        2 * size,
    )
    _, way = connected_components(cover)
    as_is, over = way[:size], way[size:]
    first = np.full(parts, 2 * size)
    np.minimum.at(first, part, as_is)
    alike = as_is == first[part]
    votes = np.bincount(part, np.where(alike, 1.0, -1.0), parts)
    usable = mixed & (votes != 0.0)
    usable[part[as_is == over]] = False
    turned = usable[part] & (alike != (votes[part] > 0.0))
    return np.where(turned[:, None], faces[:, [0, 2, 1]], faces)


def _walked_twice(faces: IntArray, count: int) -> bool:
    """Return whether some edge is walked twice in the same direction: else no two faces turn against each other."""
    walked = np.empty((3, len(faces)), np.int64)
    for side, (start, end) in zip(walked, ((0, 1), (1, 2), (2, 0)), strict=True):
        np.multiply(faces[:, start], count, out=side)
        side += faces[:, end]
    flat = walked.reshape(-1)
    flat.sort()
    return bool((flat[1:] == flat[:-1]).any())


def _graph(one: AnyIntArray, other: AnyIntArray, size: int) -> coo_array:
    return coo_array((np.ones(len(one), np.int8), (one, other)), shape=(size, size))
