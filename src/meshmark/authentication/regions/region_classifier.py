"""The distortion classifier: a small network, trained by Levenberg-Marquardt, in the paper's passes TH and BH."""

from __future__ import annotations

from functools import cache

import numpy as np

from meshmark.authentication.regions.region_evidence import FEATURES
from meshmark.mesh import FloatArray
from meshmark.network.perceptron import Perceptron
from meshmark.network.weights import shipped_network

__all__ = ["NETWORK", "distortion"]

NETWORK = "distortion"


def distortion(features: FloatArray, network: Perceptron | None = None) -> FloatArray:
    """Return log-odds (n,) that regions with features (n, 2, d) are distorted: those of the worse half.

    network: the shipped one by default.
    """
    used = _shipped() if network is None else network
    odds = used(features.reshape(-1, features.shape[-1])).reshape(-1, 2)
    return np.asarray(odds.max(axis=1))


@cache
def _shipped() -> Perceptron:
    return shipped_network(NETWORK, FEATURES)
