"""What the network is shown of a model: places, normals, waves over space, and how far each point sticks out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from meshmark.geometry.areas import vertex_normals
from meshmark.mesh import FloatArray, IntArray

__all__ = [
    "CLIP",
    "OUT",
    "WAVES",
    "Shown",
    "Single",
    "input_count",
    "mean_of_neighbours",
    "shown",
    "wave_number",
    "waves",
]

Single = NDArray[np.float32]
# Wavelengths of a model of one point, in RMS radii, and how many directions of each. They fall with the root of the
# number of points, in whole octaves of it: they are about two to four edges.
LENGTHS, DIRECTIONS = (8.5, 10.5, 13.0), 24
# What sticks out farther than this many means is shown as this far.
WAVES = len(LENGTHS) * DIRECTIONS
CLIP = 3.0
# The column that says it.
OUT = 6


@dataclass(frozen=True, eq=False)
class Shown:
    """The network's inputs (p, d), the points' means of neighbours as a matrix (p, p), normals (p, 3).

    height: mean distance of the points from the mean of their neighbours, along the normal; slope: (p,) by how
    much the input that says so changes with that distance.
    """

    values: Single
    mean: csr_array
    normals: FloatArray
    height: float
    slope: FloatArray

    def by_heights(self, by_out: Single | FloatArray) -> FloatArray:
        """Return the gradient (p,) by moves along the normals, from that by how far each point sticks out.

        What else the network sees changes little with a mark and is taken to stay.
        """
        by_second = self.slope * by_out
        by_first = by_second - self.mean.T @ by_second
        by_places = by_first[:, None] * self.normals
        by_places = by_places - self.mean.T @ by_places
        return np.asarray(np.einsum("ij,ij->i", by_places, self.normals))


def waves() -> FloatArray:
    """Return the wave vectors (3, k) of a model of one point, spread over directions."""
    golden = np.pi * (3.0 - np.sqrt(5.0))
    vectors = []
    for row, length in enumerate(LENGTHS):
        number = np.arange(DIRECTIONS)
        z = (number + 0.5) / DIRECTIONS  # half of the directions: the other half are the same waves
        angle = golden * (number + 0.37 * row * DIRECTIONS)
        flat = np.sqrt(1.0 - z * z)
        vectors.append(2.0 * np.pi / length * np.array([flat * np.cos(angle), flat * np.sin(angle), z]))
    return np.concatenate(vectors, axis=1)


def wave_number(count: int) -> float:
    """Return by how much the waves of a model of this number of points are shorter."""
    return float(2.0 ** (round(np.log2(max(count, 2))) / 2.0))


def input_count() -> int:
    """Return the number of inputs, d."""
    return OUT + 1 + 2 * WAVES


def mean_of_neighbours(graph: csr_array) -> csr_array:
    """Return the matrix (p, p) that takes the mean over the neighbours of each point, of an adjacency matrix."""
    degree = np.asarray(graph.sum(axis=1)).ravel()
    rows = diags_array(1.0 / np.maximum(degree, 1.0))
    return csr_array(rows @ graph).astype(np.float32)


def shown(points: FloatArray, faces: IntArray, mean: csr_array) -> Shown:
    """Return what the network sees of points (p, 3) in canonical coordinates."""
    normals = vertex_normals(points, faces)
    out = np.einsum("ij,ij->i", points - mean @ points, normals)
    out = out - mean @ out
    height = float(np.abs(out).mean()) or 1.0
    squashed = np.tanh(out / (CLIP * height))
    phases = points @ waves() * wave_number(len(points))
    values = np.column_stack([points, normals, CLIP * squashed, np.sin(phases), np.cos(phases)])
    return Shown(values.astype(np.float32), mean, normals, height, (1.0 - squashed**2) / height)
