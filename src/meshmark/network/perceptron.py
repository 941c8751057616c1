"""A small multilayer perceptron with one output (docs/design.md, section 5).

Inputs are centred and scaled inside, so that weights of order one suit any of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from meshmark.errors import InputError
from meshmark.mesh import FloatArray

__all__ = ["Perceptron"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Perceptron:
    """Layers of tanh units and one linear output.

    sizes:   units per layer, inputs first, e.g. (10, 16, 8, 1).
    centre, scale: (inputs,) what the inputs are centred at and divided by.
    weights: (p,) for each layer its matrix (out, in), row by row, then its biases (out,).
    """

    sizes: tuple[int, ...]
    centre: FloatArray
    scale: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        if len(self.sizes) < 2 or min(self.sizes) < 1 or self.sizes[-1] != 1:
            raise InputError(f"the layers are {self.sizes}, expected two or more, the last of one unit")
        given = (np.shape(self.centre), np.shape(self.scale), np.shape(self.weights))
        expected = ((self.sizes[0],), (self.sizes[0],), (count_weights(self.sizes),))
        if given != expected:
            raise InputError(f"centre, scale and weights have shapes {given}, expected {expected}")
        if not all(np.isfinite(part).all() for part in (self.centre, self.scale, self.weights)):
            raise InputError("a weight of the network is not finite")
        if not (self.scale > 0.0).all():
            raise InputError("a scale of the network's inputs is not positive")

    @classmethod
    def drawn(cls, inputs: FloatArray, hidden: Sequence[int], rng: np.random.Generator) -> Perceptron:
        """A network for inputs like these (n, d), with random hidden layers and an output of zero."""
        sizes = (inputs.shape[1], *hidden, 1)
        spread = inputs.std(axis=0)
        parts = []
        for fan_in, fan_out in pairwise(sizes[:-1]):
            parts += [rng.normal(size=fan_out * fan_in) / np.sqrt(fan_in), rng.normal(size=fan_out) * 0.5]
        weights = np.concatenate([*parts, np.zeros(sizes[-2] + 1)])
        return cls(
            sizes=sizes,
            centre=inputs.mean(axis=0),
            scale=np.where(spread > 0.0, spread, 1.0),
            weights=weights,
        )

    def with_weights(self, weights: FloatArray) -> Perceptron:
        """Return the same network with other weights (p,)."""
        return replace(self, weights=weights)

    def __call__(self, inputs: FloatArray) -> FloatArray:
        """Inputs (n, d) -> outputs (n,)."""
        return self._activations(inputs)[-1][:, 0]

    def jacobian(self, inputs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Inputs (n, d) -> outputs (n,) and their derivatives by the weights (n, p)."""
        layers, activations = self._layers(), self._activations(inputs)
        result = np.empty((len(inputs), len(self.weights)))
        slope = np.ones((len(inputs), 1))  # of the output by what goes into this layer's units
        end = len(self.weights)
        for (matrix, bias), below in zip(layers[::-1], activations[-2::-1], strict=True):
            start = end - matrix.size - len(bias)
            result[:, start : start + matrix.size] = np.einsum("no,ni->noi", slope, below).reshape(
                len(inputs), matrix.size
            )
            result[:, start + matrix.size : end] = slope
            slope, end = (slope @ matrix) * (1.0 - below * below), start
        return activations[-1][:, 0], result

    def _layers(self) -> list[tuple[FloatArray, FloatArray]]:
        layers, start = [], 0
        for fan_in, fan_out in pairwise(self.sizes):
            end = start + fan_out * fan_in
            layers.append(
                (self.weights[start:end].reshape(fan_out, fan_in), self.weights[end : end + fan_out])
            )
            start = end + fan_out
        return layers

    def _activations(self, inputs: FloatArray) -> list[FloatArray]:
        """Return what each layer puts out, the normalised inputs first."""
        values = [np.asarray((inputs - self.centre) / self.scale)]
        layers = self._layers()
        for matrix, bias in layers:
            values.append(np.tanh(values[-1] @ matrix.T + bias))
        matrix, bias = layers[-1]
        values[-1] = values[-2] @ matrix.T + bias
        return values


def count_weights(sizes: Sequence[int]) -> int:
    """Return how many weights and biases such layers have."""
    return sum((fan_in + 1) * fan_out for fan_in, fan_out in pairwise(sizes))
