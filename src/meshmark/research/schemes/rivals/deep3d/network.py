"""The trained network on numpy: embedder, extractor, and the extractor's gradient."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import resources

import numpy as np
from scipy.sparse import csr_array

from meshmark.research.schemes.rivals.deep3d.inputs import OUT, Shown, Single

__all__ = ["LENGTH", "Network", "Read", "shipped_network"]

# Bits of a message: payload and pilots.
LENGTH = 80


class _Layer:
    """f own + (mean of the neighbours' f) around + shift."""

    def __init__(self, arrays: Mapping[str, Single], name: str) -> None:
        self.own, self.around = arrays[f"{name}.own"], arrays.get(f"{name}.around")
        self.shift = arrays.get(f"{name}.shift", np.zeros(1, np.float32))

    def __call__(self, features: Single, mean: csr_array | None = None) -> Single:
        out: Single = features @ self.own
        out += self.shift
        if self.around is not None and mean is not None:
            out += mean @ (features @ self.around)
        return out

    def block(self, features: Single, mean: csr_array) -> Single:
        """Return the same cut off below 0."""
        out = self(features, mean)
        return np.maximum(out, np.float32(0.0), out=out)

    def back(self, gradient: Single, mean: csr_array) -> Single:
        """Return the gradient by the features, from that by the output."""
        by: Single = gradient @ self.own.T
        if self.around is not None:
            by += (mean.T @ gradient) @ self.around.T
        return by


class _Trunk:
    """A block, and residuals of two blocks each."""

    def __init__(self, arrays: Mapping[str, Single], name: str) -> None:
        count = sum(key.startswith(f"{name}.") and key.endswith(".own") for key in arrays)
        self.layers = [_Layer(arrays, f"{name}.{row}") for row in range(count)]

    def __call__(self, features: Single, mean: csr_array) -> list[Single]:
        """Return what each block gives, and after every second the sum: what the gradient needs, the last first."""
        kept = [self.layers[0].block(features, mean)]
        for first, second in zip(self.layers[1::2], self.layers[2::2], strict=False):
            inner = first.block(kept[0], mean)
            outer = second.block(inner, mean)
            kept = [kept[0] + outer, outer, inner, *kept]
        return kept

    def back(self, kept: list[Single], gradient: Single, mean: csr_array) -> Single:
        """Return the gradient by the inputs."""
        pairs = list(zip(self.layers[1::2], self.layers[2::2], strict=False))
        for row, (first, second) in enumerate(reversed(pairs)):
            outer, inner = kept[3 * row + 1], kept[3 * row + 2]
            by = second.back(gradient * (outer > 0.0), mean)
            gradient = gradient + first.back(by * (inner > 0.0), mean)
        return self.layers[0].back(gradient * (kept[-1] > 0.0), mean)


class Read:
    """What the extractor makes of a model: `logits` (LENGTH,), and how they change with the points.

    features: the last block's (n, c); gain: how much what sticks out counts at each point (n, 1).
    """

    def __init__(self, network: Network, model: Shown) -> None:
        self._network, self._model = network, model
        self._kept = network.extractor(model.values, model.mean)
        self._features = network.last.block(self._kept[0], model.mean)
        self._gain: Single = np.float32(2.0) * _sigmoid(network.gate(self._features))
        self._out = model.values[:, OUT : OUT + 1]
        self._both = np.concatenate([self._features, model.values[:, OUT + 1 :]], axis=1)
        self._root = np.float32(np.sqrt(len(self._out)))
        products = (self._both.T @ (self._gain * self._out))[:, 0] / self._root
        pooled = np.concatenate([self._features.mean(axis=0), products])
        self._hidden = np.maximum(network.perceptron[0](pooled), 0.0)
        self.logits: Single = network.out(products) + network.perceptron[1](self._hidden)

    def gradient(self, by_logits: Single) -> Single:
        """Return the gradient by how far each point sticks out, (n,), from that by the logits."""
        network, count = self._network, self._features.shape[1]
        first, second = network.perceptron
        by_pooled = first.own @ ((second.own @ by_logits) * (self._hidden > 0.0))
        by_products = (network.out.own @ by_logits + by_pooled[count:]) / self._root
        by_weighed = (self._both @ by_products)[:, None]
        by_gate = by_weighed * self._out * self._gain * (1.0 - 0.5 * self._gain)
        by_features = self._gain * self._out * by_products[:count] + by_pooled[:count] / len(self._out)
        by_features += by_gate @ network.gate.own.T
        by_trunk = network.last.back(
            np.asarray(by_features * (self._features > 0.0), np.float32), self._model.mean
        )
        by_inputs = network.extractor.back(self._kept, by_trunk, self._model.mean)
        return np.asarray(by_inputs[:, OUT] + (by_weighed * self._gain)[:, 0])


class Network:
    """Embedder and extractor with weights of the names that `export.save` gives them."""

    def __init__(self, arrays: Mapping[str, Single]) -> None:
        self.extractor, self.gate = _Trunk(arrays, "extractor.trunk"), _Layer(arrays, "extractor.gate")
        self.last, self.out = _Layer(arrays, "extractor.last.0"), _Layer(arrays, "extractor.out")
        self.perceptron = [_Layer(arrays, f"extractor.perceptron.{row}") for row in range(2)]
        self._trunk, self._after = _Trunk(arrays, "embedder.trunk"), _Trunk(arrays, "embedder.after")
        self._latent, self._weights = _Layer(arrays, "embedder.latent"), _Layer(arrays, "embedder.weights")
        self._out, self._gate = _Layer(arrays, "embedder.out"), _Layer(arrays, "embedder.gate")

    def heights(self, model: Shown, message: Single) -> Single:
        """Return moves (n,) along the normals, of RMS 1, for a message of +1 and -1 (LENGTH,)."""
        latent = np.tile(self._latent(message), (len(model.values), 1))
        known = [model.values, self._trunk(model.values, model.mean)[0], latent]
        features = self._after(np.concatenate(known, axis=1), model.mean)[0]
        waves = model.values[:, OUT + 1 :]
        patterns = np.concatenate([self._out(features, model.mean), waves], axis=1)
        heights = (patterns @ self._weights(message)) * _sigmoid(self._gate(features))[:, 0]
        return np.asarray(heights / (np.sqrt(np.mean(heights**2)) or 1.0), np.float32)


@cache
def shipped_network() -> Network:
    """Return the network that comes with the package."""
    file = resources.files("meshmark.research.schemes.rivals.deep3d").joinpath("weights.npz")
    with resources.as_file(file) as path, np.load(path, allow_pickle=False) as arrays:
        return Network({name: arrays[name].astype(np.float32) for name in arrays.files})


def _sigmoid(values: Single) -> Single:
    return np.asarray(0.5 + 0.5 * np.tanh(0.5 * values), np.float32)
