"""Weights of a trained pair as plain arrays, batch norm folded into the convolution before it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch

from meshmark.research.schemes.rivals.deep3d.model import POOLED, Embedder, Extractor

__all__ = ["save"]


def save(embedder: Embedder, extractor: Extractor, path: Path) -> None:
    """Write the weights as .npz of half precision, named as `network.Network` takes them."""
    arrays = dict(_named(embedder, extractor))
    np.savez_compressed(path, **{name: value.astype(np.float16) for name, value in arrays.items()})


def _named(embedder: Embedder, extractor: Extractor) -> Iterator[tuple[str, Any]]:
    for name, blocks in (
        ("embedder.trunk", embedder.trunk.blocks),
        ("embedder.after", embedder.after.blocks),
        ("extractor.trunk", extractor.trunk.blocks),
        ("extractor.last", [extractor.last]),
    ):
        for row, block in enumerate(blocks):
            gain = block.norm.weight / torch.sqrt(block.norm.running_var + block.norm.eps)
            own, around = block.convolution.own, block.convolution.around
            shift = block.norm.bias + gain * (own.bias - block.norm.running_mean)
            yield from _layer(
                f"{name}.{row}", gain[:, None] * own.weight, gain[:, None] * around.weight, shift
            )
    yield from _layer(
        "embedder.out", embedder.out.own.weight, embedder.out.around.weight, embedder.out.own.bias
    )
    yield "embedder.latent.own", _array(embedder.latent.weight.T)
    yield "embedder.latent.shift", _array(embedder.latent.bias)
    yield "embedder.gate.own", _array(embedder.gate.weight.T)
    yield "embedder.gate.shift", _array(embedder.gate.bias)
    yield "embedder.weights.own", _array(embedder.weights.weight.T) * _gains(embedder.gains, POOLED)
    for name, linear in (
        ("out", extractor.out),
        ("gate", extractor.gate),
        ("perceptron.0", extractor.perceptron[0]),
        ("perceptron.1", extractor.perceptron[2]),
    ):
        own, pooled = _array(linear.weight.T), {"out": POOLED, "perceptron.0": 2 * POOLED}.get(name)
        yield (
            f"extractor.{name}.own",
            own if pooled is None else own * _gains(extractor.gains, pooled)[:, None],
        )
        yield f"extractor.{name}.shift", _array(linear.bias)


def _gains(gains: Any, others: int) -> Any:
    """Return a factor for each pattern: 1 for those of the blocks, which come first, the gains for the waves."""
    return np.concatenate([np.ones(others, np.float32), _array(gains)])


def _layer(name: str, own: Any, around: Any, shift: Any) -> Iterator[tuple[str, Any]]:
    yield f"{name}.own", _array(own.T)
    yield f"{name}.around", _array(around.T)
    yield f"{name}.shift", _array(shift)


def _array(values: Any) -> Any:
    return values.detach().numpy()
