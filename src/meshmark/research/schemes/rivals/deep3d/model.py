"""The embedder and the extractor in PyTorch, for training."""

from __future__ import annotations

from typing import Any

import torch
from torch import nn

from meshmark.research.schemes.rivals.deep3d.batches import Batch
from meshmark.research.schemes.rivals.deep3d.inputs import OUT, WAVES, input_count

__all__ = ["CHANNELS", "Embedder", "Extractor", "started"]

CHANNELS, POOLED, RESIDUALS, AFTER = 64, 128, 2, 1


class GraphConv(nn.Module):
    """f' = W0 f + W1 mean of the neighbours' f."""

    def __init__(self, inward: int, outward: int) -> None:
        super().__init__()
        self.own, self.around = nn.Linear(inward, outward), nn.Linear(inward, outward, bias=False)

    def forward(self, features: Any, batch: Batch) -> Any:
        """(n, inward) -> (n, outward)."""
        return self.own(features) + self.around(batch.mean(features))


class Block(nn.Module):
    """GraphConv, batch norm, ReLU."""

    def __init__(self, inward: int, outward: int) -> None:
        super().__init__()
        self.convolution, self.norm = GraphConv(inward, outward), nn.BatchNorm1d(outward)

    def forward(self, features: Any, batch: Batch) -> Any:
        """(n, inward) -> (n, outward)."""
        return torch.relu(self.norm(self.convolution(features, batch)))


class Trunk(nn.Module):
    """A block that takes the inputs to the channels, and residuals of two blocks each."""

    def __init__(self, inward: int, residuals: int) -> None:
        super().__init__()
        self.blocks = nn.ModuleList(
            [Block(inward, CHANNELS)] + [Block(CHANNELS, CHANNELS) for _ in range(2 * residuals)]
        )

    def forward(self, features: Any, batch: Batch) -> Any:
        """(n, inward) -> (n, CHANNELS)."""
        features = self.blocks[0](features, batch)
        for first, second in zip(self.blocks[1::2], self.blocks[2::2], strict=True):
            features = features + second(first(features, batch), batch)
        return features


class Embedder(nn.Module):
    """A message becomes a height by which each point moves along its normal.

    The last layer weighs patterns over the points by the message: those that the blocks make, and the waves.
    """

    def __init__(self, length: int) -> None:
        super().__init__()
        self.trunk = Trunk(input_count(), RESIDUALS)
        self.latent = nn.Linear(length, CHANNELS)
        self.after = Trunk(input_count() + 2 * CHANNELS, AFTER)
        self.out = GraphConv(CHANNELS, POOLED)
        self.weights = nn.Linear(length, POOLED + 2 * WAVES, bias=False)
        self.gate, self.gains = nn.Linear(CHANNELS, 1), nn.Parameter(torch.ones(2 * WAVES))

    def forward(self, inputs: Any, message: Any, batch: Batch) -> Any:
        """Inputs (n, d) and messages of +1 and -1 (meshes, length) -> heights (n,) of RMS 1 in each mesh."""
        latent = self.latent(message)[batch.of]
        features = torch.cat([inputs, self.trunk(inputs, batch), latent], dim=1)
        features = self.after(features, batch)
        patterns = torch.cat([self.out(features, batch), self.gains * inputs[:, OUT + 1 :]], dim=1)
        heights = (patterns * self.weights(message)[batch.of]).sum(dim=1)
        heights = heights * torch.sigmoid(self.gate(features))[:, 0]
        power = batch.pooled(heights[:, None] ** 2)[:, 0]
        return heights / torch.sqrt(power + 1e-9)[batch.of]


class Extractor(nn.Module):
    """What is seen of a model becomes a number for each bit of the message, positive for +1."""

    def __init__(self, length: int) -> None:
        super().__init__()
        self.trunk = Trunk(input_count(), RESIDUALS)
        self.last = Block(CHANNELS, POOLED)
        pooled = 2 * POOLED + 2 * WAVES
        self.perceptron = nn.Sequential(nn.Linear(pooled, POOLED), nn.ReLU(), nn.Linear(POOLED, length))
        self.out = nn.Linear(POOLED + 2 * WAVES, length)
        self.gate, self.gains = nn.Linear(POOLED, 1), nn.Parameter(torch.ones(2 * WAVES))

    def forward(self, inputs: Any, batch: Batch) -> Any:
        """Inputs (n, d) -> (meshes, length)."""
        features = self.last(self.trunk(inputs, batch), batch)
        both = torch.cat([features, self.gains * inputs[:, OUT + 1 :]], dim=1)
        sticking_out = 2.0 * torch.sigmoid(self.gate(features)) * inputs[:, OUT : OUT + 1]
        products = batch.pooled(both * sticking_out) * batch.sizes.sqrt()[:, None]
        return self.out(products) + self.perceptron(torch.cat([batch.pooled(features), products], dim=1))


def started(length: int) -> tuple[Embedder, Extractor]:
    """Return a pair that begins as spread spectrum on the waves, which the extractor correlates with."""
    embedder, extractor = Embedder(length), Extractor(length)
    basis = torch.linalg.qr(torch.randn(2 * WAVES, length))[0]
    with torch.no_grad():
        embedder.weights.weight[POOLED:] = basis
        embedder.weights.weight[:POOLED] *= 0.1
        extractor.out.weight[:, POOLED:] = basis.T
        extractor.out.weight[:, :POOLED] *= 0.1
        extractor.perceptron[2].weight *= 0.1
    return embedder, extractor
