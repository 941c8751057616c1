"""How far a model's coordinates may be off after benign operations, and so how fine its marks can be."""

from __future__ import annotations

import numpy as np

from meshmark.errors import InputError
from meshmark.io.save import conform
from meshmark.mesh import Mesh
from meshmark.schemes.ncdg_lv.authentication.parameters import FAR_AWAY

__all__ = ["TOLERANCES", "precision_of"]

TOLERANCES = ("strict", "tolerant")
# Half the last digit of an export with six decimals.
_DECIMALS = 0.5e-6
# Half the last place of 32-bit floats, relative.
_FLOAT32 = 2.0**-24
# Half the step of a grid of 16 bits, over the longest side.
_GRID = 2.0**-17


def precision_of(mesh: Mesh, tolerance: str = "strict") -> float:
    """Return the largest error of a coordinate, in scene units, that must not break a mark.

    "strict": what the mesh's own file, an export with six decimals, and 32-bit floats after a similarity transform
    round; "tolerant": also an export with six significant digits or on a grid of 16 bits.
    Raises `InputError` for an unknown tolerance.
    """
    if tolerance not in TOLERANCES:
        raise InputError(f"unknown tolerance '{tolerance}', expected one of {', '.join(TOLERANCES)}")
    vertices = mesh.vertices
    extent = np.ptp(vertices, axis=0)
    farthest = float(np.abs(vertices).max())
    diagonal = float(np.linalg.norm(extent))
    own = _own(mesh, float(extent.max()))
    strict = max(_DECIMALS, FAR_AWAY * diagonal, 2.0 * _FLOAT32 * (farthest + diagonal), own)
    if tolerance == "strict":
        return strict
    digits = 0.5 * 10.0 ** (np.ceil(np.log10(farthest)) - 6.0)
    return max(strict, float(digits), _GRID * float(extent.max()))


def _own(mesh: Mesh, size: float) -> float:
    """Return how far the mesh's file moves coordinates that it is given."""
    nudged = mesh.vertices + size * 1e-4 * np.sin(np.arange(mesh.vertices.size)).reshape(-1, 3)
    return float(np.abs(conform(mesh, nudged) - nudged).max())
