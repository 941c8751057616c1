"""Descriptors of the surface around oriented points, blind to rotation and to the triangulation.

Everything is an integral over the surface within a ball: per shell of distance the area, the height over the
tangent plane and its square, how the normal tilts, and the size of the first angular harmonics of area and height.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array

from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.registration.surfels import Surfels
from meshmark.mesh import FloatArray, IntArray

__all__ = ["DESCRIPTOR_LENGTH", "SHELLS", "describe", "tangent_axes"]

SHELLS = 5
HARMONICS = (1, 2)
PLAIN = 5
DESCRIPTOR_LENGTH = SHELLS * (PLAIN + 2 * len(HARMONICS))


def tangent_axes(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors (n, 3) each that complete the normals to right-handed triples."""
    helper = np.zeros_like(normals)
    helper[np.arange(len(normals)), np.argmin(np.abs(normals), axis=1)] = 1.0
    first = np.cross(normals, helper)
    first /= np.sqrt(np.einsum("ij,ij->i", first, first))[:, None]
    return first, np.cross(normals, first)


def describe(surfels: Surfels, places: FloatArray, normals: FloatArray, radius: float) -> FloatArray:
    """Return (n, DESCRIPTOR_LENGTH) for n places with unit normals: integrals over balls of `radius`.

    Numbers are in units of the radius and of a flat disc's area per shell, so scaling everything changes nothing.
    """
    pairs = kd_tree(places).sparse_distance_matrix(surfels.tree, radius, output_type="ndarray")
    rows, columns, distance = pairs["i"], pairs["j"], pairs["v"] / radius
    step = (surfels.places.take(columns, axis=0) - places.take(rows, axis=0)) / radius
    channels = _channels(step, surfels.normals.take(columns, axis=0), normals, rows)
    channels *= surfels.areas.take(columns)[:, None]
    sums = _shell_sums(channels, distance, rows, len(places))
    ring = np.pi * radius**2 * (2.0 * np.arange(SHELLS) + 1.5) / (SHELLS + 0.5) ** 2
    sums /= ring[:, None]
    waves = sums[:, :, PLAIN:].reshape(len(places), SHELLS, -1, 2)
    plain = sums[:, :, :PLAIN]
    return np.concatenate([plain, np.hypot(waves[..., 0], waves[..., 1])], axis=2).reshape(len(places), -1)


def _channels(step: FloatArray, facing: FloatArray, normals: FloatArray, rows: IntArray) -> FloatArray:
    """Return (pairs, channels): what is summed over the surface, before the area."""
    axes = tangent_axes(normals)
    first, second = axes[0].take(rows, axis=0), axes[1].take(rows, axis=0)
    normal = normals.take(rows, axis=0)
    height, x, y = (np.einsum("ij,ij->i", step, axis) for axis in (normal, first, second))
    along = np.einsum("ij,ij->i", facing, normal)
    away = np.hypot(x, y)
    away[away == 0.0] = 1.0
    x, y = x / away, y / away
    tilt = np.einsum("ij,ij->i", facing, first) * x + np.einsum("ij,ij->i", facing, second) * y
    columns = [np.ones_like(height), height, height**2, along, tilt]
    for wave in (x + 1j * y) ** np.array(HARMONICS)[:, None]:
        columns += [wave.real, wave.imag, height * wave.real, height * wave.imag]
    return np.stack(columns, axis=1)


def _shell_sums(channels: FloatArray, distance: FloatArray, rows: IntArray, count: int) -> FloatArray:
    """Return (count, SHELLS, channels): sums with weights that fade from one shell to the next."""
    place = distance * (SHELLS + 0.5) - 0.5
    lower = np.floor(place).astype(np.int64)
    share = place - lower
    total = np.zeros((count * SHELLS, channels.shape[1]))
    for shell, weight in ((lower, 1.0 - share), (lower + 1, share)):
        inside = np.flatnonzero((shell >= 0) & (shell < SHELLS))
        spots = rows[inside] * SHELLS + shell[inside]
        adding = coo_array((weight[inside], (spots, inside)), shape=(len(total), len(rows)))
        total += np.asarray(adding.tocsr() @ channels)
    return total.reshape(count, SHELLS, -1)
