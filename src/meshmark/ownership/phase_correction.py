"""What is left of smoothing, noise and a wrong frame in a reading, taken off its phases.

After the lattice lock the offsets still err together: where smoothing was undone a little too far or too short,
by a multiple of each cell's bending. A few such multiples are fitted to pilots and doubled phases, as the lock is.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.quantisation import lock_score
from meshmark.ownership.carriers.weighted_squares import WeightedSquares
from meshmark.ownership.observation import Observation

__all__ = ["best_correction", "best_corrections", "corrected_phase", "shifts"]

# Expected size of each part of the correction, in radians RMS over the cells: of a part of the pose, and of a part
# of the bending where it has its typical size.
POSE_EXPECTED = 0.2
BENDING_EXPECTED = 1.0
# A bending of more than this number of typical sizes is clipped: the response is not linear that far.
LARGEST = 4.0
TINY = 1e-9
STEPS = 15
# Bending is sought from these starts, in typical sizes, with what each must better the lock by, in standard
# deviations of the lock without a mark: less is chance.
STARTS = tuple((start, 2.0 if any(start) else 0.5) for start in product((0.0, -1.2, 1.2), repeat=2))


def corrected_phase(seen: Observation) -> FloatArray:
    """Return the phases (n,) with small errors common to many cells taken off.

    The correction depends on pilots and doubled phases only: phases of other cells turned by pi give corrected
    phases turned by pi.
    """
    phase, step = seen.phase, seen.step
    if not len(phase):
        return phase
    factor, weight = seen.keys.factor, seen.keys.weight
    pose, bending = shifts(seen.cells), seen.relief.bending
    pose = pose / (np.sqrt(np.mean(pose**2, axis=0)) + TINY)
    typical = 1.5 * np.median(np.abs(bending), axis=0)  # a normal distribution's standard deviation
    bending = np.clip(bending / (typical + TINY * step), -LARGEST, LARGEST)
    response = np.hstack([POSE_EXPECTED * pose, BENDING_EXPECTED * bending])
    starts = np.array([start for start, _ in STARTS])
    margins = np.array([margin for _, margin in STARTS]) * np.sqrt(len(phase) / 2.0)
    turned = phase + starts @ bending.T
    corrections = best_corrections(
        factor * turned, factor[:, None] * response, np.ones(response.shape[1]), weight
    )
    turned = turned + corrections @ response.T
    scores = lock_score(factor * turned, weight) - margins
    best = int(np.argmax(scores))
    return np.asarray(turned[best] if scores[best] > lock_score(seen.psi, weight) else phase)


def shifts(cells: Cells) -> FloatArray:
    """Return (n, 7): change of each offset under shift, scale and turn about the cells' middle, in spacings."""
    place = cells.nodes + cells.offset[:, None] * cells.normal
    place = place - (place.mean(axis=0) if len(place) else 0.0)
    along = np.einsum("ij,ij->i", cells.normal, place)
    return np.column_stack([cells.normal, along, np.cross(place, cells.normal)])


def best_correction(
    psi: FloatArray, response: FloatArray, expected: FloatArray, weight: FloatArray
) -> FloatArray:
    """Return the correction y (d,) near 0 that maximises sum w cos(psi + response y) - |y / expected|^2 / 2.

    psi: (n,) phases that do not depend on bits; response: (n, d) their change per unit; expected: (d,) standard
    deviations of y; weight: (n,) how much each counts.
    """
    return np.asarray(best_corrections(psi[None], response, expected, weight)[0])


def best_corrections(
    psi: FloatArray, response: FloatArray, expected: FloatArray, weight: FloatArray
) -> FloatArray:
    """Return the corrections (k, d) of several sets of phases (k, n), as `best_correction` does, all at once."""
    held = 1.0 / expected**2
    best = np.zeros((len(psi), len(expected)))
    turned = np.array(psi)
    cosine = np.cos(turned)
    value = cosine @ weight
    damping = np.full(len(psi), 1e-2)
    climbing = np.arange(len(psi))
    squares = WeightedSquares(response)
    diagonal = np.arange(len(expected))
    for _ in range(STEPS):
        at = best[climbing]
        # Where a cosine is low its curvature points the wrong way; a little is kept.
        hessian = squares(weight * np.maximum(cosine[climbing], 0.1))
        hessian[:, diagonal, diagonal] += held
        hessian[:, diagonal, diagonal] *= 1.0 + damping[climbing, None]
        slope = -(weight * np.sin(turned[climbing])) @ response - held * at
        ahead = at + np.linalg.solve(hessian, slope[..., None])[..., 0]
        moved = psi[climbing] + ahead @ response.T
        there = np.cos(moved)
        gain = there @ weight - 0.5 * (ahead**2) @ held - value[climbing]
        up = gain > 0.0
        rows = climbing[up]
        damping[rows] /= 3.0
        damping[climbing[~up]] *= 5.0
        best[rows], turned[rows], cosine[rows] = ahead[up], moved[up], there[up]
        value[rows] += gain[up]
        climbing = climbing[~up | (gain >= 1e-6 * psi.shape[1])]
        if not len(climbing):
            break
    return best
