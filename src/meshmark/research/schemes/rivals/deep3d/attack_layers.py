"""Attacks that gradients go through, one for each batch of training: none, rotation, noise, smoothing, crop."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from meshmark.research.schemes.rivals.deep3d.batches import Batch

__all__ = ["LAYERS", "attacked"]

LAYERS = ("none", "rotation", "noise", "smoothing", "crop")
# Largest turn and shift that are left when a model is in its frame; noise in sizes of the mark; passes and step of
# smoothing; the share of the points that a crop takes at most.
TURN, SHIFT, NOISE, PASSES, STEP, CROP = 0.02, 0.01, 1.0, 10, 0.1, 0.25


def attacked(layer: str, batch: Batch, points: Any, size: Any, rng: np.random.Generator) -> tuple[Batch, Any]:
    """Return the batch and places (n, 3) after an attack; size: (meshes,), the RMS of the mark."""
    if layer == "rotation":
        turn = np.eye(3) + TURN * np.cross(np.eye(3), rng.uniform(-1.0, 1.0, 3))
        return batch, points @ _tensor(turn) + _tensor(SHIFT * rng.uniform(-1.0, 1.0, 3))
    if layer == "noise":
        drawn = _tensor(rng.normal(0.0, NOISE * rng.random(), tuple(points.shape)))
        return batch, points + drawn * size[batch.of][:, None]
    if layer == "smoothing":
        for _ in range(int(rng.integers(1, PASSES + 1))):
            points = points + STEP * (batch.mean(points) - points)
        return batch, points
    if layer == "crop":
        along = (batch.points @ _tensor(rng.normal(size=3))).numpy()
        limit = np.quantile(along, 1.0 - CROP * rng.random())
        kept = torch.from_numpy(along <= limit)
        return batch.part(kept), points[kept]
    return batch, points


def _tensor(values: Any) -> Any:
    return torch.from_numpy(np.asarray(values, np.float32))
