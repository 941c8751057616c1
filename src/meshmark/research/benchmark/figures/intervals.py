"""95 % confidence intervals for rates and for means over models.

One family serves both. A rate has the exact interval of Clopper and Pearson: it never covers less than it says,
also for 0 of n and n of n, which are the usual results here and where simpler intervals promise too much. A mean
of values with known limits has the interval of Gaffke (2005; Learned-Miller and Thomas, arXiv:1905.06208): a
bootstrap with random weights in which one further value at the limit stands for what was not seen. For values of 0
and 1 it is that of Clopper and Pearson: thirty models without an error do not prove that there is never one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from meshmark.mesh import FloatArray

__all__ = ["Estimate", "mean", "per_model", "rate", "rate_by_model", "upper_limit"]

_TAIL = 0.025
_DRAWS = 4000  # the limits then lie within about 1 % of the interval's width
_SEED = 20_071_128


@dataclass(frozen=True)
class Estimate:
    """A mean or a rate, the limits of its 95 % interval, and the number of independent values behind it."""

    value: float
    low: float
    high: float
    count: int


def rate(hits: int, trials: int) -> Estimate | None:
    """Return the rate of independent trials with its Clopper-Pearson interval; None for no trials."""
    if not trials:
        return None
    return Estimate(hits / trials, *_limits_of_rate(hits, trials, _TAIL), trials)


def upper_limit(hits: int, trials: int) -> float:
    """Return the rate that is exceeded with at most 5 % confidence: for 0 hits about 3 / trials; 1 for none."""
    return _limits_of_rate(hits, trials, 0.05)[1] if trials else 1.0


def mean(values: Sequence[float], limits: tuple[float, float] = (0.0, 1.0)) -> Estimate | None:
    """Return the mean of independent values in [limits] with its interval; None for no values.

    The random weights come from a fixed seed: the same values give the same interval.
    """
    if not values:
        return None
    lowest, highest = limits
    z = np.sort((np.asarray(values, float) - lowest) / (highest - lowest))
    if np.isin(z, (0.0, 1.0)).all():
        low, high = _limits_of_rate(int(z.sum()), len(z), _TAIL)
    else:
        low, high = _limits_of_mean(z)
    scale = highest - lowest
    centre = float(np.mean(z))
    return Estimate(
        lowest + scale * centre, lowest + scale * min(low, centre), lowest + scale * max(high, centre), len(z)
    )


def rate_by_model(hits: Sequence[bool], models: Sequence[str]) -> Estimate | None:
    """Return the rate of trials that may share models, with an interval that counts models and not trials.

    Trials on one model are alike, so each model has one voice: its own rate. With one trial for each model this is
    Clopper-Pearson. The rate itself is that of all trials.
    """
    voices = per_model([float(hit) for hit in hits], models)
    spread = mean(voices)
    if spread is None:
        return None
    value = sum(hits) / len(hits)
    return Estimate(value, min(spread.low, value), max(spread.high, value), len(hits))


def per_model(values: Sequence[float], models: Sequence[str]) -> list[float]:
    """Return the mean of each model's values, in the order of the models' names."""
    grouped: dict[str, list[float]] = {}
    for model, value in zip(models, values, strict=True):
        grouped.setdefault(model, []).append(value)
    return [float(np.mean(grouped[model])) for model in sorted(grouped)]


def _limits_of_rate(hits: int, trials: int, tail: float) -> tuple[float, float]:
    from scipy.special import betaincinv

    low = 0.0 if hits == 0 else float(betaincinv(hits, trials - hits + 1, tail))
    high = 1.0 if hits == trials else float(betaincinv(hits + 1, trials - hits, 1.0 - tail))
    return low, high


def _limits_of_mean(z: FloatArray) -> tuple[float, float]:
    weights = _weights(len(z))
    seen = weights[:, 1:] @ z
    low = np.quantile(seen, _TAIL)  # the value not seen at 0
    high = np.quantile(seen + weights[:, 0], 1.0 - _TAIL)  # and at 1
    return float(low), float(high)


@lru_cache(maxsize=64)
def _weights(count: int) -> FloatArray:
    """Return (draws, count + 1) weights of sum 1, uniform among those: Dirichlet(1, ..., 1)."""
    weights = np.random.default_rng(_SEED).standard_exponential((_DRAWS, count + 1))
    shares: FloatArray = weights / weights.sum(axis=1, keepdims=True)
    return shares
