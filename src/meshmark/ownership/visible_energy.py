"""How visible a displacement along the normals is, as a quadratic form: masked gradient energy."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from meshmark.geometry.stiffness import stiffness
from meshmark.geometry.visibility import VisibleChange
from meshmark.mesh import FloatArray, IntArray

__all__ = ["visible_energy"]

# Vertices of tiny area would jump far for little effect; all count at least this share of the mean.
LEAST_AREA = 0.1
# Where the surface is rougher than this curvature (over the canonical scale), moments hang on single vertices,
# which would jump: they weigh more.
STEEPEST = 40.0
# Energy of a displacement itself beside that of its slopes, per spacing^2: bumps decay within 1 / sqrt of this, so
# that they hardly touch cells of other keys' lattices (docs/decisions/0019).
DECAY = 8.0
# Width in spacings over which what is noticed is averaged.
AVERAGE = 0.3


def visible_energy(
    placed: FloatArray, faces: IntArray, areas: FloatArray, frame: FloatArray, seen: VisibleChange
) -> sp.csr_array:
    """Return (p, p): the integral of m (DECAY d^2 + |grad d|^2) over displacements d (p,).

    A slope of the displacement turns the normals; m, the mask, is one over the square of the change that is just
    noticed, with a mean of 1.

    placed: (p, 3) lattice coordinates; areas: (p,); frame: (9, p) change of the frame values.
    """
    steep = np.zeros(len(areas))
    for row in frame:
        np.maximum(steep, np.abs(row), out=steep)
    steep *= areas.sum()
    steep /= STEEPEST
    mass = np.maximum(areas, LEAST_AREA * areas.mean())
    weights = seen.noticed_at(mass, stiffness(placed, faces), AVERAGE) ** -2.0
    weights /= weights @ mass / mass.sum()
    slopes = stiffness(placed, faces, weights[faces].mean(axis=1))
    return sp.csr_array(sp.diags_array(DECAY * weights * np.maximum(mass, steep)) + slopes)
