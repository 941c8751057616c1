"""Whether it shows that a model is marked: detectors trained on other models, originals and marked copies.

*plain*: statistics of how points lie among their neighbours and of the surface's energy in bands about as wide as
the bumps of a mark, judged by a logistic regression. *calibrated*: these, what smoothing changes in them, and their
products, by a kernel. A score of each model comes from detectors that never saw it; the area under the ROC curve is
that of all scores together.
"""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

import numpy as np
from scipy.optimize import minimize

import meshmark as mm
from claims.security.features import calibrated_features, plain_features
from claims.security.options import Options
from claims.security.table import Figure
from meshmark.coding.keys import Key
from meshmark.mesh import FloatArray, Mesh
from meshmark.research.training.region_training import area_under_curve

__all__ = ["area", "judged_by_kernel", "judged_by_regression", "steganalysis"]

MODELS, KEYS = 16, 3
BARS = {"subtle": 0.55, "standard": 0.60}
RIDGE, KERNEL_RIDGE = 3.0, 0.3
# Standard deviations beyond which a feature counts no more.
CLIPPED = 4.0

Judge = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Features (n, d) and labels (n,) of other models, features (m, d) of one -> scores (m,)."""


def steganalysis(options: Options) -> list[Figure]:
    """Return the area under the ROC curve of both detectors at each strength."""
    covers: list[tuple[str, Mesh]] = []
    marked: dict[str, list[tuple[str, Mesh]]] = {strength: [] for strength in BARS}
    for name, mesh in options.meshes("models"):
        copies: dict[str, list[Mesh]] = {}
        try:
            for strength in BARS:
                copies[strength] = [
                    mm.embed(mesh, Key(bytes([row + 1]) * 32), id=row + 9, strength=strength).mesh
                    for row in range(KEYS)
                ]
        except mm.MeshmarkError:
            continue
        covers.append((name, mesh))
        for strength, made in copies.items():
            marked[strength] += [(name, each) for each in made]
        print(f"{name}: {len(mesh.vertices)} vertices", flush=True)
        if len(covers) == options.count(MODELS) or monotonic() > options.end:
            break
    figures = []
    detectors = (
        ("plain", plain_features, judged_by_regression),
        ("calibrated", calibrated_features, judged_by_kernel),
    )
    for detector, features, judge in detectors:
        before = np.array([features(mesh) for _, mesh in covers])
        for strength, bar in BARS.items():
            after = np.array([features(mesh) for _, mesh in marked[strength]])
            values = np.concatenate([before, after])
            labels = np.repeat([0.0, 1.0], [len(before), len(after)])
            names = np.array([name for name, _ in covers + marked[strength]])
            found = area(values, labels, names, judge)
            is_held = detector == "plain"
            figures.append(
                Figure(
                    name=f"{strength}, {detector} detector: area under the ROC curve",
                    measured=f"{found:.2f}",
                    of=f"{len(before)} models, {len(after)} copies",
                    bar=f"at most {bar:.2f}" if is_held else "",
                    met=found <= bar if is_held else None,
                )
            )
    return figures


def area(values: FloatArray, labels: FloatArray, names: np.ndarray, judge: Judge) -> float:
    """Return the area under the ROC curve of scores (n,) that are given with the model of that name left out."""
    scores = np.zeros(len(labels))
    for name in np.unique(names):
        own = names == name
        middle, spread = values[~own].mean(axis=0), values[~own].std(axis=0) + 1e-9
        scaled = np.clip((values - middle) / spread, -CLIPPED, CLIPPED)
        scores[own] = judge(scaled[~own], labels[~own], scaled[own])
    return area_under_curve(scores, labels == 1.0)


def _balanced(labels: FloatArray) -> FloatArray:
    """Return weights (n,) that let both classes count the same."""
    return np.asarray(
        np.where(labels == 1.0, 0.5 / max(labels.sum(), 1.0), 0.5 / max((1.0 - labels).sum(), 1.0))
    )


def judged_by_regression(known: FloatArray, labels: FloatArray, asked: FloatArray) -> FloatArray:
    """Score by a logistic regression with a ridge."""
    signs, weights = 2.0 * labels - 1.0, _balanced(labels) * len(labels)

    def loss(model: FloatArray) -> tuple[float, FloatArray]:
        margin = signs * (known @ model[1:] + model[0])
        slope = -weights * signs / (1.0 + np.exp(np.clip(margin, -50.0, 50.0)))
        gradient = np.concatenate([[slope.sum()], known.T @ slope + RIDGE * model[1:]])
        return float(weights @ np.logaddexp(0.0, -margin) + 0.5 * RIDGE * model[1:] @ model[1:]), gradient

    model = minimize(loss, np.zeros(known.shape[1] + 1), jac=True, method="L-BFGS-B").x
    return np.asarray(asked @ model[1:] + model[0])


def judged_by_kernel(known: FloatArray, labels: FloatArray, asked: FloatArray) -> FloatArray:
    """Score by kernel ridge regression, Gaussian and linear kernels together."""
    width = float(known.shape[1])

    def kernel(one: FloatArray, other: FloatArray) -> FloatArray:
        apart = ((one[:, None, :] - other[None, :, :]) ** 2).sum(axis=2)
        return np.asarray(np.exp(-apart / width) + one @ other.T / width)

    weights = _balanced(labels) * len(labels)
    solved = np.linalg.solve(kernel(known, known) + KERNEL_RIDGE * np.diag(1.0 / weights), 2.0 * labels - 1.0)
    return np.asarray(kernel(asked, known) @ solved)
