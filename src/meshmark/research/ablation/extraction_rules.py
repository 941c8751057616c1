"""Extraction by the Levenberg-Marquardt networks, and by the plain rules that they replace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from meshmark.authentication.regions.region_classifier import distortion
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.quantisation import log_likelihood_ratio
from meshmark.ownership.demodulator import demodulate
from meshmark.research.training.demodulator_trials import Trial
from meshmark.research.training.region_trials import RegionTrial

__all__ = ["EXTRACTIONS", "Extraction"]

# Of the binomial rule, -log10 of the chance from which on a region is called altered.
RULE: Final = 3.0
_SURE: Final = 99.0


@dataclass(frozen=True)
class Extraction:
    """How a reading and regions are judged.

    bits: soft bits (n,) of a reading, positive for 0 and none for pilots.
    regions: of each region (n,), altered where above 0.
    """

    bits: Callable[[Trial], FloatArray]
    regions: Callable[[RegionTrial], FloatArray]


def _network_bits(trial: Trial) -> FloatArray:
    return demodulate(trial.seen)


def _rule_bits(trial: Trial) -> FloatArray:
    return np.where(trial.seen.keys.pilot, 0.0, log_likelihood_ratio(trial.seen.phase))


def _network_regions(trial: RegionTrial) -> FloatArray:
    return _judged(trial, distortion(trial.features))


def _rule_regions(trial: RegionTrial) -> FloatArray:
    return _judged(trial, -trial.log10_chance.min(axis=1) - RULE)


def _judged(trial: RegionTrial, scores: FloatArray) -> FloatArray:
    """Return the scores where a check failed; a region that holds most of an altered part is altered anyway."""
    failed = trial.features[:, :, 2].max(axis=1) > 0.0
    return np.where(trial.home, _SURE, np.where(failed, scores, -_SURE))


EXTRACTIONS: dict[str, Extraction] = {
    "network": Extraction(_network_bits, _network_regions),
    "rule": Extraction(_rule_bits, _rule_regions),
}
