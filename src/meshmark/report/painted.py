"""The colour of a painted surface: at places of its triangles, and at the vertices of a mesh."""

from __future__ import annotations

import numpy as np

from meshmark.io.colors import to_linear
from meshmark.io.paint import Paint
from meshmark.mesh import FloatArray, IntArray

__all__ = ["painted_at", "painted_vertices"]

_LINEAR = to_linear(np.arange(256) / 255.0)
# A vertex takes its colour from a little within each of its triangles, as images end at the seams.
_WITHIN = np.array([[0.9, 0.05, 0.05], [0.05, 0.9, 0.05], [0.05, 0.05, 0.9]])
_AT_ONCE = 1 << 19


def painted_at(paint: Paint, face: IntArray, weights: FloatArray) -> FloatArray:
    """Return (k, 3) linear RGB at places of triangles.

    face: (k,) triangle of each place. weights: (k, 3) barycentric coordinates in it.
    """
    colours = paint.factor[face].astype(np.float64)
    place = np.einsum("kc,kci->ki", weights, paint.places[face])
    place -= np.floor(place)
    image = paint.image[face]
    for number, pixels in enumerate(paint.images):
        here = np.flatnonzero(image == number)
        size = np.array(pixels.shape[1::-1])
        column, row = np.minimum((place[here] * size).astype(np.int64), size - 1).T
        colours[here] *= _LINEAR[pixels[row, column]]
    return colours


def painted_vertices(paint: Paint, faces: IntArray, count: int) -> FloatArray:
    """Return (count, 3) linear RGB: of each vertex the mean over its triangles (m, 3); white where it has none."""
    sums, uses = np.zeros((3, count)), np.bincount(faces.ravel(), minlength=count)
    for start in range(0, len(faces), _AT_ONCE):
        some = np.arange(start, min(start + _AT_ONCE, len(faces)))
        for corner, weights in zip(faces[some].T, _WITHIN, strict=True):
            colours = painted_at(paint, some, np.broadcast_to(weights, (len(some), 3)))
            for total, channel in zip(sums, colours.T, strict=True):
                total += np.bincount(corner, channel, count)
    return np.where(uses[:, None] > 0, sums.T / np.maximum(uses, 1)[:, None], 1.0)
