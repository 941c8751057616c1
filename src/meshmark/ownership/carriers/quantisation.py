"""Quantisation index modulation of the cells' offsets (docs/design.md, section 4).

Bit b of a cell puts its offset on the nearest point of step * (Z + dither + b/2). The same formula read
backwards gives a soft value, and, of doubled phases, a lock score that does not depend on the bits.
"""

from __future__ import annotations

import numpy as np

from meshmark.mesh import FloatArray, IntArray

__all__ = [
    "bit_phase",
    "lock_score",
    "log10_lock_chance",
    "log_likelihood_ratio",
    "log_likelihood_ratio_of_points",
    "nearest_offsets",
    "phase_noise",
    "wrapped_normal",
]

# Share of cells taken to say nothing, so that no single one can outvote many.
BROKEN_SHARE = 0.03
# Of points, the shares that are tried, and the variances of the phases of the others, in square radians.
BROKEN_SHARES = np.array([0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
WIDTHS: FloatArray = np.asarray(4e-4 * 4.0 ** np.arange(7), dtype=np.float64)


def nearest_offsets(
    offsets: FloatArray, dither: FloatArray, bits: IntArray, step: float, cost: FloatArray
) -> FloatArray:
    """Return the changes (n,) that put every offset on a lattice point of its bit at little total cost.

    cost: (n, n) positive definite, energy of a change r is r' cost r. Rounding each offset alone forces
    overlapping cells against each other, so single steps up or down are taken while they save energy.
    """
    change = step * (np.round(offsets / step - dither - bits / 2.0) + dither + bits / 2.0) - offsets
    force = cost @ change
    own = step * step * np.diag(cost)
    for _ in range(8 * len(offsets)):
        saving = own - 2.0 * step * np.abs(force)
        best = int(np.argmin(saving))
        if saving[best] >= -1e-12 * own[best]:
            break
        turn = -step if force[best] > 0.0 else step
        change[best] += turn
        force += turn * cost[:, best]
    return change


def bit_phase(offsets: FloatArray, dither: FloatArray, step: float | FloatArray) -> FloatArray:
    """Return phases (n,) in radians: 0 where the offset lies on a point for bit 0, pi for bit 1."""
    return 2.0 * np.pi * (offsets / step - dither)


def lock_score(psi: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the sum of weight cos psi over the last axis: about 0 +- sqrt(n / 2) without a mark.

    psi: (..., n) phases that do not depend on bits; weight: (n,) with squares of mean 1.
    """
    return np.asarray(np.cos(psi) @ weight)


def log10_lock_chance(score: float, count: int) -> float:
    """Bound log10 of the chance that `count` cells reach `score` without a mark.

    Keyed dithers make the phases uniform; E exp(l w cos) = I_0(l w) <= exp(l^2 w^2 / 4) gives
    exp(-score^2 / sum w^2), and the squares of the weights add up to `count`.
    """
    return -(score * score) / (count * np.log(10.0)) if score > 0.0 and count else 0.0


def log_likelihood_ratio(phase: FloatArray) -> FloatArray:
    """Return log P(phase | 0) / P(phase | 1), (n,), for a noise level read from the phases themselves.

    Wrapped normal noise whose width gives the observed lock score, with a share of broken cells of any phase.
    """
    agreement = np.clip(np.cos(2.0 * phase).mean(), 0.02, 0.98)
    variance = -0.5 * np.log(agreement)  # E cos(2 phase) = exp(-2 variance)
    return _ratio(phase, float(variance), BROKEN_SHARE)


def log_likelihood_ratio_of_points(phase: FloatArray) -> FloatArray:
    """Return log P(phase | 0) / P(phase | 1), (n,), where many carriers may be broken and the others hardly off.

    As `log_likelihood_ratio`, with the share of the broken and the width of the noise that make the doubled phases
    likeliest: those do not depend on the bits, so without a mark the signs stay fair coins.
    """
    if not len(phase):
        return np.zeros(0)
    variance, broken = phase_noise(2.0 * phase, 4.0 * WIDTHS)
    return _ratio(phase, 0.25 * variance, broken / (1.0 - broken))


def phase_noise(phase: FloatArray, variances: FloatArray = WIDTHS) -> tuple[float, float]:
    """Return (variance, share of broken carriers) that make phases (n,) about 0 likeliest, of those that are tried.

    Wrapped normal noise, in square radians; broken carriers have any phase.
    """
    normal = np.stack([wrapped_normal(phase, variance) for variance in variances])
    mixed = (1.0 - BROKEN_SHARES[:, None, None]) * normal + BROKEN_SHARES[:, None, None] / (2.0 * np.pi)
    likelihood = np.log(mixed).sum(axis=2)
    share, width = np.unravel_index(int(likelihood.argmax()), likelihood.shape)
    return float(variances[width]), float(BROKEN_SHARES[share])


def _ratio(phase: FloatArray, variance: float, broken: float) -> FloatArray:
    """Return the log-likelihood ratio under wrapped normal noise; broken: share of any phase, over the others."""
    zero, one = (wrapped_normal(phase - centre, variance) for centre in (0.0, np.pi))
    floor = broken / (2.0 * np.pi)
    return np.asarray(np.log(zero + floor) - np.log(one + floor))


def wrapped_normal(angle: FloatArray, variance: float) -> FloatArray:
    """Return the density of normal noise of this variance, wrapped onto the circle, at angles in radians."""
    nearest = angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
    turns = 2.0 * np.pi * np.array([-1.0, 0.0, 1.0])
    density = np.exp(-((nearest[..., None] + turns) ** 2) / (2.0 * variance)).sum(axis=-1)
    return np.asarray(density / np.sqrt(2.0 * np.pi * variance))
