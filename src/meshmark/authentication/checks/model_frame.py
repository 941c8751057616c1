"""Where the marked model lies in a suspect's scene, by the marks that carry their place.

Half of them carry it coarsely over the whole model, the other half finely but only modulo a share of it: the first
fit a similarity, the second make it precise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import AnyIntArray
from meshmark.authentication.marks.candidates import Candidates
from meshmark.authentication.marks.symbols import directions, is_fine, place_values
from meshmark.mesh import FloatArray, IntArray

__all__ = ["DOUBTS", "SLACK", "Evidence", "ModelFrame", "Scale", "evidence_of", "fit_frame"]

DOUBTS = 3.0
"""Deviations of the fit, which a small part determines badly far away from it."""
# A mark farther from its place than this number of times what it may be off was put there, or holds by chance.
_FAR = 4.0

# Fewer coarse marks of the largest part, and fewer fine ones, cannot say where the model lies.
_NEEDED, _NEEDED_FINE = 12, 6
SLACK = 1.0
"""A coarse mark may be this far from its place beyond the half step of rounding, in steps of its symbol."""
_FINE_SLACK = 0.1


@dataclass(frozen=True, eq=False, kw_only=True)
class Evidence:
    """What e marks say of their places.

    vertex: (e,). centre: (e, 3) of the ring in the suspect. direction: (e, 3) unit and value: (e,) where the
    centre lay along it in the marked model, in half diagonals from the middle. step: (e,) of the value. period:
    (e,) values are known but for multiples of it, infinite of coarse ones. error: of a centre, in scene units.
    """

    vertex: AnyIntArray
    centre: FloatArray
    direction: FloatArray
    value: FloatArray
    step: FloatArray
    period: FloatArray
    error: float = 0.0

    @property
    def fine(self) -> NDArray[np.bool_]:
        """Return (e,): which values are known modulo a period."""
        return np.isfinite(self.period)

    def misfit(self, along: FloatArray) -> FloatArray:
        """Return (e,) how far `along` (e,), places along the directions, are off the values."""
        off = along - self.value
        wide = np.where(self.fine, self.period, 1.0)
        return np.where(self.fine, off - wide * np.rint(off / wide), off)


@dataclass(frozen=True)
class Scale:
    """Of the marked model in the suspect's scene.

    half: of its diagonal, 0 where it is unknown; doubt: its relative standard deviation.
    """

    half: float = 0.0
    doubt: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class ModelFrame:
    """The similarity from a suspect's scene to the marked model, in half diagonals from the middle of its box.

    x -> linear @ (x - middle) + shift. covariance: (7, 7) of small turns, shifts and the logarithm of the scale.
    error: of a centre, in scene units.
    """

    middle: FloatArray
    linear: FloatArray
    shift: FloatArray
    covariance: FloatArray
    scale: Scale
    error: float

    @property
    def blur(self) -> float:
        """Return the error of a centre in half diagonals."""
        return self.error / self.scale.half if self.scale.half > 0.0 else 0.0

    def __call__(self, points: FloatArray) -> FloatArray:
        """Return where points (k, 3) lay in the marked model."""
        return np.asarray((points - self.middle) @ self.linear.T + self.shift)

    def doubt(self, points: FloatArray, direction: FloatArray) -> FloatArray:
        """Return one standard deviation (k,) of where points lay along directions (k, 3)."""
        rows = _columns(self(points) - self.shift, direction)
        return np.asarray(np.sqrt(np.einsum("ei,ij,ej->e", rows, self.covariance, rows).clip(min=0.0)))

    def off(self, evidence: Evidence) -> FloatArray:
        """Return (e,) how far each mark lies from where it says, in half diagonals."""
        along = np.einsum("ei,ei->e", self(evidence.centre), evidence.direction)
        return np.abs(evidence.misfit(along))

    def far(self, evidence: Evidence) -> NDArray[np.bool_]:
        """Return (e,): which marks lie so far from where they say that they are not believed."""
        return np.asarray(self.off(evidence) > _FAR * self.allowed(evidence, DOUBTS))

    def allowed(self, evidence: Evidence, doubts: float) -> FloatArray:
        """Return (e,) how far off each mark may be: rounding of value and coordinates, and `doubts` deviations."""
        rounding = np.where(evidence.fine, 0.5 + _FINE_SLACK, 0.5 + SLACK) * evidence.step + 2.0 * self.blur
        return np.asarray(rounding + doubts * self.doubt(evidence.centre, evidence.direction))


def evidence_of(found: Candidates, symbol: IntArray, symbol_bits: int, error: float) -> Evidence:
    """Return what marks (e,) that carry their place say; symbol: (e,) read; error: of a centre, in scene units."""
    value, step, period = place_values(symbol, is_fine(found.index), symbol_bits)
    return Evidence(
        vertex=found.vertex,
        centre=found.centre,
        direction=directions(found),
        value=value,
        step=step,
        period=period,
        error=error,
    )


def fit_frame(evidence: Evidence, own: NDArray[np.bool_]) -> ModelFrame | None:
    """Return the similarity that suits the marks `own` (e,) best, None where they are too few or suit none.

    Few marks close together may suit a wrong similarity nearly as well as the right one. So one is also fitted to
    the marks of all parts, and taken where it suits as many of `own` and more of the others.
    """
    coarse = ~evidence.fine
    if (own & coarse).sum() < _NEEDED:  # scattered marks, of parts that are all small
        own = np.ones(len(own), bool)
    if (own & coarse).sum() < _NEEDED:
        return None
    frames = [_fitted(evidence, own & coarse), _fitted(evidence, coarse)]
    near = (0.5 + SLACK) * evidence.step
    off = [frame.off(evidence) for frame in frames]
    right = [(each <= near) & coarse for each in off]
    best = max((0, 1), key=lambda i: (int(right[i][own].sum()), int(right[i].sum())))
    if np.median((off[best] / evidence.step)[own & coarse]) > 1.0:
        return None
    return _refined(evidence, own, frames[best])


def _refined(evidence: Evidence, own: NDArray[np.bool_], frame: ModelFrame) -> ModelFrame:
    """Return a frame that suits the fine marks `own` (e,), too; as it is where they are too few."""
    for _ in range(4):
        off = frame.off(evidence)
        near = off <= frame.allowed(evidence, 4.0)
        # A fine mark whose place is not known to a quarter of its period says nothing yet.
        sure = 4.0 * frame.doubt(evidence.centre, evidence.direction) < 0.25 * evidence.period
        use = own & near & sure
        if (use & evidence.fine).sum() < _NEEDED_FINE:
            return frame
        frame = _improved(evidence, use, frame)
    return frame


def _improved(evidence: Evidence, use: NDArray[np.bool_], frame: ModelFrame) -> ModelFrame:
    """Return a frame after one step of weighted least squares on the marks `use` (e,)."""
    from scipy.spatial.transform import Rotation

    sigma = np.sqrt(evidence.step**2 / 12.0 + frame.blur**2)[use]
    moved = frame(evidence.centre) - frame.shift
    along = np.einsum("ei,ei->e", moved + frame.shift, evidence.direction)
    rows = _columns(moved, evidence.direction)[use] / sigma[:, None]
    change = np.linalg.lstsq(rows, -evidence.misfit(along)[use] / sigma, rcond=1e-12)[0]
    growth = float(np.exp(np.clip(change[6], -0.1, 0.1)))
    linear = growth * Rotation.from_rotvec(change[:3]).as_matrix() @ frame.linear
    covariance = np.asarray(np.linalg.pinv(rows.T @ rows, hermitian=True), np.float64)
    scale = Scale(frame.scale.half / growth, float(np.sqrt(max(covariance[6, 6], 0.0))))
    return replace(frame, linear=linear, shift=frame.shift + change[3:6], covariance=covariance, scale=scale)


def _fitted(evidence: Evidence, fitted: NDArray[np.bool_]) -> ModelFrame:
    """Return the similarity of most of the marks `fitted` (e,), all of them coarse."""
    from scipy.spatial.transform import Rotation

    middle = evidence.centre[fitted].mean(axis=0)
    points = evidence.centre - middle
    size = float(np.sqrt((points[fitted] ** 2).sum(axis=1).mean())) or 1.0
    points /= size
    direction, value, step = evidence.direction, evidence.value, evidence.step
    use = fitted
    turn, scale, shift = _first_guess(points[use], direction[use], value[use])
    rows = np.empty((len(points), 7))
    for _ in range(8):
        moved = scale * points @ turn.T
        misfit = np.einsum("ei,ei->e", moved + shift, direction) - value
        # A mark that may be in its place is no outlier: without it the others may suit another place as well.
        widest = np.maximum(3.0 * float(np.median(np.abs(misfit[fitted]))), (0.5 + SLACK) * step)
        use = fitted & (np.abs(misfit) <= widest)
        rows = _columns(moved, direction)
        change = np.linalg.lstsq(rows[use], -misfit[use], rcond=1e-9)[0]
        turn = Rotation.from_rotvec(change[:3]).as_matrix() @ turn
        shift = shift + change[3:6]
        scale *= float(np.exp(np.clip(change[6], -1.0, 1.0)))
    spread = np.linalg.pinv(rows[use].T @ rows[use], hermitian=True) * float(np.mean(step[use] ** 2)) / 12.0
    return ModelFrame(
        middle=middle,
        linear=scale / size * turn,
        shift=shift,
        covariance=np.asarray(spread, np.float64),
        scale=Scale(size / scale, float(np.sqrt(max(spread[6, 6], 0.0)))),
        error=evidence.error,
    )


def _columns(moved: FloatArray, direction: FloatArray) -> FloatArray:
    """Return (e, 7) how places along directions change with a small turn, shift and growth."""
    growth = np.einsum("ei,ei->e", moved, direction)[:, None]
    return np.concatenate([np.cross(moved, direction), direction, growth], axis=1)


def _first_guess(
    points: FloatArray, direction: FloatArray, value: FloatArray
) -> tuple[FloatArray, float, FloatArray]:
    """Return rotation, scale and shift near the affine map that suits best."""
    columns = (direction[:, :, None] * points[:, None, :]).reshape(len(points), 9)
    solved = np.linalg.lstsq(np.concatenate([columns, direction], axis=1), value, rcond=1e-6)[0]
    u, s, vt = np.linalg.svd(solved[:9].reshape(3, 3))
    sign = np.sign(np.linalg.det(u @ vt))
    return np.asarray(u * [1.0, 1.0, sign] @ vt), float(s[:2].mean()), np.asarray(solved[9:])
