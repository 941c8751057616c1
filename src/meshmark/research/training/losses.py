"""What a network is trained to: losses of its outputs, summed over chunks of samples.

Each sample's output is multiplied by a gain of its own before it is judged: with gain cos(phase) the network
says how much a phase counts, and the phase which way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray
from meshmark.network.perceptron import Perceptron
from meshmark.research.training.levenberg_marquardt import Normal

__all__ = ["LOSSES", "Objective", "logistic", "squares"]

# Samples at once: their Jacobian stays in the cache.
CHUNK = 2048

# Value, first and second derivative by z, each (n,), of the loss of outputs z (n,) with targets (n,).
Loss = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]


def squares(outputs: FloatArray, targets: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Half the squared difference."""
    error = outputs - targets
    return 0.5 * error * error, error, np.ones_like(error)


def logistic(outputs: FloatArray, targets: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """-log of the chance of target +1 or -1 where the output is the log-likelihood ratio of +1 to -1."""
    margin = outputs * targets
    wrong = np.exp(-np.logaddexp(0.0, margin))
    return np.logaddexp(0.0, -margin), -targets * wrong, wrong * (1.0 - wrong)


LOSSES: dict[str, Loss] = {"squares": squares, "logistic": logistic}


@dataclass(frozen=True, eq=False, kw_only=True)
class Objective:
    """The mean loss of a network over n samples, as a function of its weights, plus half ridge |weights|^2.

    inputs: (n, d); gain: (n,) factor of each output; targets: (n,); shares: (n,) how much each sample counts.
    """

    network: Perceptron
    loss_of: Loss
    inputs: FloatArray
    gain: FloatArray
    targets: FloatArray
    shares: FloatArray
    ridge: float = 0.0

    def __post_init__(self) -> None:
        lengths = {len(part) for part in (self.inputs, self.gain, self.targets, self.shares)}
        if len(lengths) != 1 or not self.shares.sum() > 0.0:
            raise InputError(
                "inputs, gain, targets and shares must be of one length, and some share positive"
            )

    def loss(self, weights: FloatArray) -> float:
        """Return the loss at these weights (p,)."""
        network, total = self.network.with_weights(weights), 0.0
        for part in blocks(len(self.inputs), CHUNK):
            outputs = self.gain[part] * network(self.inputs[part])
            total += float(self.shares[part] @ self.loss_of(outputs, self.targets[part])[0])
        return total / float(self.shares.sum()) + 0.5 * self.ridge * float(weights @ weights)

    def expand(self, weights: FloatArray) -> Normal:
        """Return the loss at these weights (p,) with its derivatives, the Hessian in Gauss-Newton's form."""
        network, total = self.network.with_weights(weights), 0.0
        gradient, hessian = np.zeros(len(weights)), np.zeros((len(weights), len(weights)))
        for part in blocks(len(self.inputs), CHUNK):
            outputs, jacobian = network.jacobian(self.inputs[part])
            gain, shares = self.gain[part], self.shares[part]
            value, first, second = self.loss_of(gain * outputs, self.targets[part])
            total += float(shares @ value)
            gradient += (shares * gain * first) @ jacobian
            scaled = jacobian * (gain * np.sqrt(shares * second))[:, None]
            hessian += scaled.T @ scaled
        count = float(self.shares.sum())
        return Normal(
            loss=total / count + 0.5 * self.ridge * float(weights @ weights),
            gradient=gradient / count + self.ridge * weights,
            hessian=hessian / count + self.ridge * np.eye(len(weights)),
        )
