"""How much a surface hides: where it is rough by itself, a change of its shading is not seen.

Roughness is the RMS angle of the normals against normals smoothed along the surface, at the scale of a cell. What
hides a change is neighbouring detail of the same scale (visual masking).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.stiffness import diffused
from meshmark.mesh import FloatArray
from meshmark.ownership import x_experiment as X

__all__ = ["mask", "roughness"]

# Widths in spacings: of what counts as the smooth surface, and over which roughness is averaged.
SMOOTH = 0.3
AVERAGE = 0.5
# Roughness in radians at which a change is half as visible as on a smooth surface, squared: about 1.7 degrees.
HALF = 0.03


def roughness(normals: FloatArray, mass: FloatArray, stiff: sp.csr_array) -> FloatArray:
    """Return the roughness (p,), radians, of a surface in lattice coordinates.

    normals: (p, 3) unit; mass, stiff: as in `diffused`.
    """
    rest = normals - diffused(normals, mass, stiff, SMOOTH)
    # Constant curvature shortens the mean normal, and is smooth.
    rest -= normals * np.einsum("pi,pi->p", rest, normals)[:, None]
    square = np.einsum("pi,pi->p", rest, rest)[:, None]
    return np.sqrt(np.maximum(diffused(square, mass, stiff, AVERAGE)[:, 0], 0.0))


def mask(rough: FloatArray, mass: FloatArray) -> FloatArray:
    """Return weights (p,), mean 1 over the surface, of what a change costs: less where the surface is rough."""
    weights = (HALF**2 / (HALF**2 + rough**2)) ** X.POWER
    return np.asarray(weights / (weights @ mass / mass.sum()))
