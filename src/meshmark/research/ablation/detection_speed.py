"""How long each way to find salient points takes (paper eq. 16)."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from meshmark.errors import CapacityError
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.research.ablation.modules import SALIENCY

__all__ = ["detection_figures"]

REPEATS = 3


def detection_figures(mesh: Mesh, rng: np.random.Generator) -> dict[str, Any]:
    """Return {way: {"seconds": best of a few, "points": salient ones}}; raises `CapacityError` without surface."""
    surface = weld(mesh)
    if not len(surface.faces):
        raise CapacityError("the model has no face with three different points, expected a surface")
    figures = {}
    for name, find in SALIENCY.items():
        seconds = []
        for _ in range(REPEATS):
            start = perf_counter()
            _, peaks = find(surface.points, surface.faces, rng)
            seconds.append(perf_counter() - start)
        figures[name] = {"seconds": min(seconds), "points": len(peaks)}
    return figures
