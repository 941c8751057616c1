"""The soft demodulator: from phases of a reading to log-likelihood ratios of bits (docs/design.md, section 5).

LLR = cos(phase) times what the network makes of features that depend on pilots and doubled phases only. Without
a mark the keyed dithers make each phase as likely as the same turned by pi, whatever all others are. That turn of
a cell that carries a bit changes the sign of its ratio and nothing else: *given all magnitudes the signs are fair
coins*, as the bound of `Codec.decode` needs, however the network was trained.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.network.perceptron import Perceptron
from meshmark.network.weights import shipped_network
from meshmark.ownership.carrier_features import FEATURES, carrier_features
from meshmark.ownership.observation import Observation
from meshmark.ownership.phase_correction import corrected_phase

__all__ = ["NETWORK", "demodulate"]

NETWORK = "demodulator"


def demodulate(seen: Observation, network: Perceptron | None = None) -> FloatArray:
    """Return log P(phase | 0) / P(phase | 1), (n,), of the cells of a reading; 0 of pilots, which carry no bit.

    network: the shipped one by default.
    """
    corrected = replace(seen, phase=corrected_phase(seen))
    used = _shipped() if network is None else network
    ratio = np.cos(corrected.phase) * used(carrier_features(corrected))
    return np.asarray(np.where(seen.keys.pilot, 0.0, ratio))


@cache
def _shipped() -> Perceptron:
    return shipped_network(NETWORK, FEATURES)
