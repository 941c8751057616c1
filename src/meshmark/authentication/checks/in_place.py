"""Which marks that hold also lie where they were: parts that were moved whole, or pasted, are found here.

A part that is moved as one keeps the marks inside it. But it hangs together with the rest by no mark that
holds, and some of its marks say where in the model they belong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.geometry.components import connected_components
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Evidence", "Scale", "in_place"]

# Fewer marks of the largest part that carry their place cannot say where the model lies.
_NEEDED = 12
# A part may be this far from its place, in steps of the symbol; half a step is rounding.
_SLACK = 1.0
# And this number of deviations of the fit, which a small part determines badly far away from it.
_DOUBTS = 3.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Evidence:
    """What e marks say of their places.

    vertex: (e,). centre: (e, 3) of the ring in the suspect. direction: (e, 3) unit and value: (e,) where the
    centre lay along it in the marked model, in half diagonals from the middle. step: of the value.
    """

    vertex: IntArray
    centre: FloatArray
    direction: FloatArray
    value: FloatArray
    step: float


@dataclass(frozen=True)
class Scale:
    """Of the marked model in the suspect's scene.

    half: of its diagonal, 0 where it is unknown; doubt: its relative standard deviation.
    """

    half: float = 0.0
    doubt: float = 0.0


def in_place(
    edges: IntArray,
    passed: NDArray[np.bool_],
    pairs: IntArray,
    failing: NDArray[np.bool_],
    evidence: Evidence,
    *,
    lucky: int = 0,
) -> tuple[NDArray[np.bool_], Scale]:
    """Return which of the marks that hold to believe, and the scale of the model according to them.

    Marks that share points of their rings are one part. The largest part is believed; another one where most of its
    own evidence agrees with the largest part's, or, without any, where it touches nothing that fails: a connected
    component of its own.

    Parameters
    ----------
    edges : (e, 2) int array
        Of the surface.
    passed : (p,) bool array
        The marks that hold.
    pairs : (n, 2) int array
        Each mark that holds and a point of its ring.
    failing : (p,) bool array
        Points that no mark vouches for, though one should.
    evidence : Evidence
        Where marks say that they lie.
    lucky : int
        Number of marks of a part that may hold by chance although they lie elsewhere.

    Returns
    -------
    believed : (p,) bool array
    scale : Scale
    """
    part = _parts(pairs, len(passed))
    count = int(part.max(initial=-1)) + 1
    if not passed.any():
        return passed, Scale()
    main = int(np.bincount(part[passed], minlength=count).argmax())
    agrees, disputes, scale = _votes(part, main, evidence, count)
    touched = np.zeros(count, bool)
    for start, end in (edges.T, edges[:, ::-1].T):
        touched[part[start[failing[end] & ~failing[start]]]] = True
    touched[part[failing]] = True
    believed = np.where(disputes > agrees + lucky, False, (agrees >= _least(agrees, touched)))
    believed[main] = True
    return passed & believed[part], scale


def _least(agrees: IntArray, touched: NDArray[np.bool_]) -> IntArray:
    """Return (parts,) how many marks must agree: two next to something that fails, else none."""
    return np.where(touched, np.full_like(agrees, 2), 0)


def _parts(pairs: IntArray, count: int) -> IntArray:
    graph = csr_array((np.ones(len(pairs), np.int8), pairs.T), shape=(count, count))
    return connected_components(graph)[1]


def _votes(part: IntArray, main: int, evidence: Evidence, count: int) -> tuple[IntArray, IntArray, Scale]:
    """Return how many marks of each part lie, and do not lie, where the largest part puts them; and its scale."""
    own = part[evidence.vertex] == main
    found = _misfit(evidence, own)
    if found is None:
        return np.zeros(count, np.int64), np.zeros(count, np.int64), Scale()
    misfit, doubt, scale = found
    right = misfit <= (0.5 + _SLACK) * evidence.step + _DOUBTS * doubt
    where = part[evidence.vertex]
    return np.bincount(where[right], minlength=count), np.bincount(where[~right], minlength=count), scale


def _misfit(evidence: Evidence, own: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray, Scale] | None:
    """Return how far each mark lies from where it says, after the similarity that suits `own` (e,) best.

    And how far off that similarity may be there: one standard deviation, from the rounding of the values; and the
    scale. Few marks close together may suit a wrong similarity nearly as well as the right one. So one is also
    fitted to the marks of all parts, and taken where it suits as many of `own` and more of the others.
    """
    if own.sum() < _NEEDED:
        return None
    fits = [_fit(evidence, own), _fit(evidence, np.ones(len(own), bool))]
    near = (0.5 + _SLACK) * evidence.step
    right = [fit[0] <= near for fit in fits]
    best = max((0, 1), key=lambda i: (int(right[i][own].sum()), int(right[i].sum())))
    return fits[best] if np.median(fits[best][0][own]) <= evidence.step else None


def _fit(evidence: Evidence, fitted: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray, Scale]:
    """Return misfit (e,), its deviation (e,) and scale for the similarity of most of the marks `fitted` (e,)."""
    from scipy.spatial.transform import Rotation

    middle = evidence.centre[fitted].mean(axis=0)
    points = evidence.centre - middle
    size = float(np.sqrt((points[fitted] ** 2).sum(axis=1).mean()))
    points /= size if size > 0.0 else 1.0
    direction, value = evidence.direction, evidence.value
    use = fitted
    turn, scale, shift = _first_guess(points[use], direction[use], value[use])
    for _ in range(8):
        moved = scale * points @ turn.T
        misfit = np.einsum("ei,ei->e", moved + shift, direction) - value
        # A mark that may be in its place is no outlier: without it the others may suit another place as well.
        widest = max(3.0 * float(np.median(np.abs(misfit[fitted]))), (0.5 + _SLACK) * evidence.step)
        use = fitted & (np.abs(misfit) <= widest)
        columns = [np.cross(moved, direction), direction, np.einsum("ei,ei->e", moved, direction)[:, None]]
        rows = np.concatenate(columns, axis=1)
        change = np.linalg.lstsq(rows[use], -misfit[use], rcond=1e-9)[0]
        turn = Rotation.from_rotvec(change[:3]).as_matrix() @ turn
        shift = shift + change[3:6]
        scale *= float(np.exp(np.clip(change[6], -1.0, 1.0)))
    misfit = np.einsum("ei,ei->e", scale * points @ turn.T + shift, direction) - value
    spread = np.linalg.pinv(rows[use].T @ rows[use], hermitian=True) * evidence.step**2 / 12.0
    doubt = np.sqrt(np.einsum("ei,ij,ej->e", rows, spread, rows).clip(min=0.0))
    return np.abs(misfit), doubt, Scale((size or 1.0) / scale, float(np.sqrt(max(spread[6, 6], 0.0))))


def _first_guess(
    points: FloatArray, direction: FloatArray, value: FloatArray
) -> tuple[FloatArray, float, FloatArray]:
    """Return rotation, scale and shift near the affine map that suits best."""
    columns = (direction[:, :, None] * points[:, None, :]).reshape(len(points), 9)
    solved = np.linalg.lstsq(np.concatenate([columns, direction], axis=1), value, rcond=1e-6)[0]
    u, s, vt = np.linalg.svd(solved[:9].reshape(3, 3))
    sign = np.sign(np.linalg.det(u @ vt))
    return np.asarray(u * [1.0, 1.0, sign] @ vt), float(s[:2].mean()), np.asarray(solved[9:])
