"""Smooth pseudo-random fields without any state."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from demo_model.solids import Array


def noise(p: Array, seed: int = 0) -> Array:
    """Return smooth noise of about unit wavelength, in [-1, 1], at points (..., 3)."""
    cell = np.floor(p).astype(np.int64)
    f = p - cell
    blend = f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
    total = np.zeros(p.shape[:-1])
    for corner in np.ndindex(2, 2, 2):
        offset = np.array(corner)
        weight = np.where(offset, blend, 1.0 - blend).prod(axis=-1)
        gradient = np.stack([_hash(cell + offset, seed + 17 * k) for k in range(3)], axis=-1)
        total += weight * np.sum(gradient * (f - offset), axis=-1)
    return total


def brushed(p: Array, flow: Callable[[Array], Array], length: float, width: float, seed: int) -> Array:
    """Return noise drawn out along a flow into streaks of the given length and width, about unit variance."""
    total = noise(p / width, seed)
    count, steps = 1, 6
    for sign in (1.0, -1.0):
        q = p.copy()
        for _ in range(steps):
            q = q + flow(q) * (sign * length / (2 * steps))
            total = total + noise(q / width, seed)
            count += 1
    return total / (np.sqrt(count) * 0.25)


def _hash(cell: Array, seed: int) -> Array:
    x, y, z = (cell[..., k].astype(np.uint64) for k in range(3))
    with np.errstate(over="ignore"):
        h = x * np.uint64(0x9E3779B1) ^ y * np.uint64(0x85EBCA77) ^ z * np.uint64(0xC2B2AE3D)
        h = (h + np.uint64(seed)) * np.uint64(0x9E3779B97F4A7C15)
        h ^= h >> np.uint64(29)
        h *= np.uint64(0xBF58476D1CE4E5B9)
        h ^= h >> np.uint64(32)
    return (h >> np.uint64(11)).astype(np.float64) / 2.0**52 - 1.0
