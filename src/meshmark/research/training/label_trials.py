"""How far attacks move the invariants of a model, as its reader sees them: what the label map is fitted to."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

import numpy as np

from meshmark.attacks import find_attack
from meshmark.errors import MeshmarkError
from meshmark.geometry.invariants import INVARIANTS, shape_invariants
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.search.restoration import restorations

__all__ = ["ATTACKED", "MODERATE", "Drift", "drifts"]

# Attacks that leave all of the surface: of a part the certificate tells the label.
MODERATE: Final = (
    ("noise", 0.005),
    ("smoothing", 30.0),
    ("quantisation", 8.0),
    ("simplification", 0.9),
    ("midpoint", 1.0),
)
ATTACKED: Final = (
    *MODERATE,
    ("noise", 0.01),
    ("noise", 0.02),
    ("smoothing", 50.0),
    ("smoothing_half", 10.0),
    ("quantisation", 7.0),
    ("simplification", 0.95),
    ("remeshing", 1.0),
)
# Remeshing runs in a process of its own, and larger models take it long.
MOST_REMESHED: Final = 5_000
_MOMENTS: Final = slice(0, 3)


@dataclass(frozen=True, eq=False, kw_only=True)
class Drift:
    """Changes (k, 16) of the invariants by an attack, a row for each restoration, the shape as it stands first."""

    attack: str
    strength: float
    change: FloatArray

    @property
    def frame_change(self) -> float:
        """The largest change of a log ratio of neighbouring moments, of the restoration with the least."""
        moments = self.change[:, _MOMENTS]
        return float(np.abs(np.diff(moments, axis=1)).max(axis=1).min())


def drifts(mesh: Mesh, rng: np.random.Generator) -> Iterator[Drift]:
    """Yield the drift under each attack of `ATTACKED` that can be made of the model."""
    surface = weld(mesh)
    truth = shape_invariants(surface.points, surface.faces)
    for name, strength in ATTACKED:
        if name == "remeshing" and len(surface.points) > MOST_REMESHED:
            continue
        with suppress(MeshmarkError):
            attacked = weld(find_attack(name)(mesh, strength, rng))
            shapes = [restoration.between(restoration.middle) for restoration in restorations(attacked)]
            rows = [shape_invariants(points, attacked.faces) for points in shapes]
            change = np.array(rows).reshape(len(rows), len(INVARIANTS)) - truth
            yield Drift(attack=name, strength=strength, change=change)
