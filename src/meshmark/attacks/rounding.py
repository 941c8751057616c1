"""Coordinates on a grid, and coordinates in single precision."""

from __future__ import annotations

import numpy as np

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.moved_vertices import moved
from meshmark.errors import InputError
from meshmark.mesh import FloatArray, Mesh

__all__ = ["float32", "quantisation", "to_float32"]


def quantisation(mesh: Mesh, strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Round every coordinate to the nearest `low + k * step`, k = 0 .. 2^bits; strength is the number of bits.

    step = (high - low) / 2^bits, axis by axis, over the vertices. An axis without extent stays.
    """
    low = mesh.vertices.min(axis=0)
    step = np.ptp(mesh.vertices, axis=0) / 2.0**strength
    flat = step == 0.0
    index = np.rint((mesh.vertices - low) / np.where(flat, 1.0, step))
    return moved(mesh, np.where(flat, mesh.vertices, low + index * step))


def float32(mesh: Mesh, _strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Round every coordinate to the nearest 32-bit float; raises `InputError` for one beyond their range."""
    return moved(mesh, to_float32(mesh.vertices))


def to_float32(vertices: FloatArray) -> FloatArray:
    """Return positions rounded to 32-bit floats; raises `InputError` for one beyond their range."""
    with np.errstate(over="ignore"):
        rounded = vertices.astype(np.float32).astype(np.float64)
    if not np.isfinite(rounded).all():
        raise InputError("a coordinate is beyond the range of 32-bit floats, expected at most 3.4e38")
    return rounded
