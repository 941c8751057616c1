"""Whether angles are no better than drawn at random, as those of an attack that has learnt nothing are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import kstest

from claims.security.table import Figure
from meshmark.mesh import FloatArray

__all__ = ["Uniformity", "uniformity"]


@dataclass(frozen=True, kw_only=True)
class Uniformity:
    """rayleigh: chance that uniform phases lean so much to one value; kolmogorov: that they differ so much from all
    values alike; towards: mean cosine, 1 where the attack is right each time, about 0 by chance; count: of phases.
    """

    rayleigh: float
    kolmogorov: float
    towards: float
    count: int

    def holds(self, level: float = 0.01) -> bool:
        """Return whether neither test rejects that the phases are uniform."""
        return min(self.rayleigh, self.kolmogorov) > level

    def figure(self, name: str, of: str) -> Figure:
        """Return the row of a table, whose bar is that the phases are uniform."""
        return Figure(name=name, measured=str(self), of=of, bar="uniform: p above .01", met=self.holds())

    def __str__(self) -> str:
        return (
            f"p = {self.rayleigh:.2g} (Rayleigh), {self.kolmogorov:.2g} (KS), mean cosine {self.towards:+.3f}"
        )


def uniformity(turns: FloatArray) -> Uniformity:
    """Test phases (n,), in turns, modulo 1."""
    within = np.mod(turns, 1.0)
    if not len(within):
        return Uniformity(rayleigh=1.0, kolmogorov=1.0, towards=0.0, count=0)
    angles = 2.0 * np.pi * within
    return Uniformity(
        rayleigh=_rayleigh(angles),
        kolmogorov=float(kstest(within, "uniform").pvalue),
        towards=float(np.cos(angles).mean()),
        count=len(within),
    )


def _rayleigh(angles: FloatArray) -> float:
    """Return the p-value of Rayleigh's test (Zar 1999, equation 27.4)."""
    n = len(angles)
    length = abs(np.exp(1j * angles).sum())
    return float(min(1.0, np.exp(np.sqrt(1.0 + 4.0 * n + 4.0 * (n * n - length**2)) - (1.0 + 2.0 * n))))
