"""Small surfaces made by code, for tests."""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray


def sphere_with_a_spike(across: int = 24) -> tuple[FloatArray, IntArray, int]:
    """A closed latitude-longitude sphere, one point pulled out; returns points, faces, that point."""
    turn = 2 * np.pi * np.arange(across) / across
    rise = np.pi * np.arange(1, across // 2) / (across // 2)
    rings = np.stack(
        [
            np.outer(np.sin(rise), np.cos(turn)),
            np.outer(np.sin(rise), np.sin(turn)),
            np.outer(np.cos(rise), np.ones(across)),
        ],
        axis=2,
    )
    points = np.concatenate([rings.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    here = np.arange((len(rise) - 1) * across).reshape(-1, across)
    right = np.roll(here, -1, axis=1)
    sides = [np.stack([here, here + across, right], -1), np.stack([right, here + across, right + across], -1)]
    first, last = np.arange(across), np.arange(across) + (len(rise) - 1) * across
    top = np.stack([np.full(across, len(points) - 2), first, np.roll(first, -1)], axis=1)
    bottom = np.stack([np.full(across, len(points) - 1), np.roll(last, -1), last], axis=1)
    faces = np.concatenate([side.reshape(-1, 3) for side in sides] + [top, bottom])
    points += 1e-3 * np.random.default_rng(1).normal(size=points.shape)  # no two places alike
    tip = 5 * across + 7
    points[tip] *= 1.3
    return points, faces, tip


def pebble(across: int = 72) -> tuple[FloatArray, IntArray]:
    """A closed, lopsided shape with dents, about across^2/2 points; its frame is well defined."""
    points, faces, _ = sphere_with_a_spike(across)
    unit = points / np.linalg.norm(points, axis=1)[:, None]
    x, y, z = unit.T
    radius = 1.0 + 0.25 * x + 0.15 * x * y + 0.2 * z**3 + 0.08 * np.sin(4 * y) * x + 0.05 * np.cos(5 * z + x)
    return unit * radius[:, None] * [1.6, 1.2, 1.0], faces


def boulder(across: int = 72, relief: float = 0.01) -> tuple[FloatArray, IntArray]:
    """A pebble with a rough surface, which hides more of a mark; relief: RMS, the pebble being about 3 long."""
    points, faces = pebble(across)
    random = np.random.default_rng(5)
    waves = random.normal(size=(3, 60))
    waves *= random.uniform(12.0, 30.0, 60) / np.linalg.norm(waves, axis=0)
    bumps = np.sin(points @ waves + random.uniform(0.0, 2.0 * np.pi, 60)).sum(axis=1) / np.sqrt(30.0)
    return points * (1.0 + relief * bumps)[:, None], faces


def hoop(long: int = 2500, around: int = 6, thin: float = 0.0015) -> tuple[FloatArray, IntArray]:
    """A closed wavy tube, very thin: even rings that are a thousandth of the whole; long * around points."""
    along, about = np.meshgrid(
        2 * np.pi * np.arange(long) / long, 2 * np.pi * np.arange(around) / around, indexing="ij"
    )
    radius = thin * (1.0 + 0.2 * np.sin(7 * along + about) + 0.1 * np.cos(23 * along))
    out = 1.0 + 0.1 * np.sin(3 * along) + radius * np.cos(about)
    height = radius * np.sin(about) + 0.2 * np.sin(2 * along)
    points = np.stack([out * np.cos(along), 0.8 * out * np.sin(along), height], axis=-1).reshape(-1, 3)
    points += 0.03 * thin * np.random.default_rng(0).normal(size=points.shape)
    here = np.arange(long * around).reshape(long, around)
    right, up = np.roll(here, -1, axis=0), np.roll(here, -1, axis=1)
    corner = np.roll(right, -1, axis=1)
    sides = [np.stack([here, right, up], -1), np.stack([right, corner, up], -1)]
    return points, np.concatenate([side.reshape(-1, 3) for side in sides])
