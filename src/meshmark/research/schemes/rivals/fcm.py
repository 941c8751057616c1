"""Vertices chosen by fuzzy c-means of their rings (Zein et al. 2017), moved along their normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.geometry.areas import area_vectors, vertex_normals
from meshmark.mesh import FloatArray, IntArray
from meshmark.research.schemes.rivals.codeword import chips, votes
from meshmark.research.schemes.rivals.fuzzy import fuzzy_c_means
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.rival import Informed
from meshmark.research.schemes.scheme import Bits

__all__ = ["Fcm", "carriers"]

VALENCE = 6
# Clusters from flat to sharp; the middle one carries.
CLUSTERS, MODERATE = 3, 1


@dataclass(frozen=True)
class Fcm(Informed):
    """Vertices of six neighbours whose rings are neither flat nor sharp; each carries a code bit, in a keyed order.

    A bit is a step along the normal, up or down by a keyed sign, as long as the ring's spread (its standard
    deviation about its mean) times a strength. The reader compares with the original how far the vertex is from its
    ring's mean.
    """

    title = "Fuzzy c-means, informed"
    source = "Zein et al. 2017, method I"
    reconstruction = (
        "ring features, step along the normal, reading by the original, keyed signs and pilots are ours"
    )
    pilots: int = 32

    def _placed(self, host: Host, code: Bits, key: Key, budget: float) -> FloatArray:
        vertices, steps = carriers(host)
        if len(vertices) < self._length:
            raise CapacityError(
                f"the model has {len(vertices)} vertices that can carry a bit, expected at least {self._length}"
            )
        bit, sign = chips(key, "fcm", len(vertices), self._length)
        moves = np.zeros_like(host.points)
        moves[vertices] = steps * (sign * (1.0 - 2.0 * code[bit]))[:, None]
        return host.points + moves * (0.99 * budget / host.rms(host.points + moves))

    def _compared(self, original: Host, moved: FloatArray, weights: FloatArray, key: Key) -> FloatArray:
        vertices, steps = carriers(original)
        bit, sign = chips(key, "fcm", len(vertices), self._length)
        around = (original.graph @ moved) / np.maximum(original.graph.sum(axis=1), 1.0)[:, None]
        rise = np.einsum("ij,ij->i", (moved - around)[vertices], steps)
        return votes(bit, sign * rise * weights[vertices], self._length)


def carriers(host: Host) -> tuple[IntArray, FloatArray]:
    """Return the vertices (k,) that carry, and a step (k, 3) for each: its normal times its ring's spread."""
    vertices = np.flatnonzero(np.diff(host.graph.indptr) == VALENCE)
    if len(vertices) < CLUSTERS:
        return vertices, np.zeros((len(vertices), 3))
    normals = vertex_normals(host.points, host.faces)
    shares = fuzzy_c_means(_angles(host, normals)[vertices], CLUSTERS)[1]
    vertices = vertices[np.argmax(shares, axis=1) == MODERATE]
    return vertices, normals[vertices] * _spread(host)[vertices, None]


def _angles(host: Host, normals: FloatArray) -> FloatArray:
    """Return (p, 2): mean and largest angle between a vertex's normal and the normals of its faces."""
    vectors = area_vectors(host.points, host.faces)
    size = np.linalg.norm(vectors, axis=1)
    unit = vectors / np.where(size > 0.0, size, 1.0)[:, None]
    corners = host.faces.ravel()
    cosine = np.einsum("ij,ij->i", normals[corners], np.repeat(unit, 3, axis=0))
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    largest = np.zeros(len(host.points))
    np.maximum.at(largest, corners, angle)
    count = np.bincount(corners, minlength=len(host.points))
    return np.column_stack([np.bincount(corners, angle, len(host.points)) / np.maximum(count, 1), largest])


def _spread(host: Host) -> FloatArray:
    """Return (p,): the standard deviation of each vertex's neighbours about their mean."""
    degree = np.maximum(np.asarray(host.graph.sum(axis=1)), 1.0)
    centred = host.points - host.points.mean(axis=0)
    mean = (host.graph @ centred) / degree[:, None]
    square = (host.graph @ np.einsum("ij,ij->i", centred, centred)) / degree
    return np.asarray(np.sqrt(np.maximum(square - np.einsum("ij,ij->i", mean, mean), 0.0)))
