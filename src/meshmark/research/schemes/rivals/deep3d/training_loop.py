"""Training embedder and extractor together, in PyTorch (tools/train_deep3d.py)."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import torch
from torch.nn.functional import softplus
from torch.nn.utils import clip_grad_norm_

from meshmark.research.schemes.rivals.deep3d.attack_layers import LAYERS, attacked
from meshmark.research.schemes.rivals.deep3d.batches import Batch
from meshmark.research.schemes.rivals.deep3d.examples import Example
from meshmark.research.schemes.rivals.deep3d.export import save
from meshmark.research.schemes.rivals.deep3d.model import Embedder, Extractor, started
from meshmark.research.schemes.rivals.deep3d.network import LENGTH

__all__ = ["train"]

# Meshes of a step; the mark's size is this many means of what the points stick out, times a spread factor.
MESHES, SIZE, SPREAD = 4, 2.5, 0.8
RATE, GAINS_RATE, LARGEST_GRADIENT = 3e-4, 3e-3, 1.0
# Weight of the curvature in the loss.
CURVATURE = 0.002
# Steps between two lines of the curve; one model in this number is held out for it.
EVERY, ASIDE = 50, 12


def train(models: Sequence[Example], steps: int, seed: int, out: Path, curve: Path) -> None:
    """Train on models, write the weights and the curve as it goes."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    rng = np.random.default_rng(seed)
    embedder, extractor = started(LENGTH)
    parameters = [*embedder.parameters(), *extractor.parameters()]
    gains = [embedder.gains, extractor.gains]
    others = [each for each in parameters if all(each is not gain for gain in gains)]
    optimiser = torch.optim.Adam([{"params": others, "lr": RATE}, {"params": gains, "lr": GAINS_RATE}])
    plan = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    aside, fit = list(models[::ASIDE]), [each for row, each in enumerate(models) if row % ASIDE]
    start, lines, seen = perf_counter(), [], []
    for step in range(1, steps + 1):
        picked = [_turned(fit[i], rng) for i in rng.integers(0, len(fit), MESHES)]
        size = SIZE * np.exp(SPREAD * rng.normal(size=MESHES))
        message, curvature, errors = _run(embedder, extractor, picked, size, rng.choice(LAYERS), rng)
        optimiser.zero_grad()
        (message + CURVATURE * curvature).backward()
        clip_grad_norm_(parameters, LARGEST_GRADIENT)
        optimiser.step()
        plan.step()
        seen.append((message.item(), curvature.item(), errors))
        if step % EVERY == 0 or step == steps:
            held = _held(embedder, extractor, aside)
            lines.append([step, perf_counter() - start, *np.mean(seen, axis=0), *held])
            print(" ".join(f"{value:.4g}" for value in lines[-1]), flush=True)
            seen = []
            save(embedder, extractor, out)
            _write(curve, lines)


def _run(
    embedder: Embedder,
    extractor: Extractor,
    meshes: Sequence[Example],
    size: Any,
    layer: str,
    rng: np.random.Generator,
) -> tuple[Any, Any, float]:
    """Return the losses of message and curvature, and the share of wrong bits, of marked and attacked meshes."""
    batch = Batch(meshes)
    bits = torch.from_numpy(rng.choice([-1.0, 1.0], (len(meshes), LENGTH)).astype(np.float32))
    normals = batch.normals(batch.points)
    sizes = batch.heights(batch.points, normals)[1] * torch.from_numpy(size.astype(np.float32))
    heights = embedder(batch.inputs(batch.points), bits, batch) * sizes[batch.of]
    moved = batch.points + heights[:, None] * normals
    change = (batch.curvature(moved) - batch.curvature(batch.points)) ** 2
    there, points = attacked(layer, batch, moved, sizes, rng)
    read = extractor(there.inputs(points), there)
    return softplus(-read * bits).mean(), change.mean(), float((read * bits < 0.0).float().mean())


def _held(embedder: Embedder, extractor: Extractor, aside: Sequence[Example]) -> list[float]:
    """Return the share of wrong bits of models kept aside, as they are and with each attack layer."""
    embedder.eval()
    extractor.eval()
    with torch.no_grad():
        size = np.full(len(aside), SIZE)
        rates = [
            _run(embedder, extractor, aside, size, layer, np.random.default_rng(1))[2] for layer in LAYERS
        ]
    embedder.train()
    extractor.train()
    return rates


def _turned(example: Example, rng: np.random.Generator) -> Example:
    """Return the model at any angle, perhaps mirrored."""
    points, faces = example
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return points @ turn, faces if np.linalg.det(turn) > 0.0 else faces[:, ::-1]


def _write(path: Path, lines: Sequence[Sequence[float]]) -> None:
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(
            ["step", "seconds", "message", "curvature", "errors", *(f"aside_{name}" for name in LAYERS)]
        )
        table.writerows([[f"{value:.5g}" for value in line] for line in lines])
