"""Training of the distortion classifier on locally edited models (docs/design.md, section 5; paper eq. 13-15)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from meshmark.authentication.regions.region_classifier import distortion
from meshmark.errors import InputError
from meshmark.mesh import FloatArray
from meshmark.network.perceptron import Perceptron
from meshmark.research.training.fitting import Examples, Recipe, fitted, held_out
from meshmark.research.training.region_trials import RegionTrial

__all__ = ["TrainedClassifier", "area_under_curve", "region_scores", "train_classifier"]

RECIPE: Final = Recipe(hidden=(8, 4), ridge=1e-4, passes=80, patience=10, starts=4)
# Every so-manieth model is for validation.
VALIDATION: Final = 4


@dataclass(frozen=True, eq=False)
class TrainedClassifier:
    """The network, and notes on how it was made and how good it is on the validation models."""

    network: Perceptron
    notes: dict[str, Any]


def train_classifier(models: Mapping[str, Sequence[RegionTrial]], seed: int) -> TrainedClassifier:
    """Train on the trials of each model; every fourth model is held out to say when to stop.

    Raises `InputError` for fewer than two models.
    """
    names, held = held_out(models, VALIDATION)
    fit = [trial for name in names for trial in models[name]]
    validation = [trial for name in held for trial in models[name]]
    found, network = fitted(_table(fit), _table(validation), RECIPE, seed)
    rule, net, truth = region_scores(validation, network)
    notes = {
        "seed": seed,
        "models for fitting": names,
        "models for validation": held,
        "edited models": [len(fit), len(validation)],
        "loss in nats": [round(found.loss, 5), round(found.watched, 5)],
        "area under the curve, validation, rule and network": [
            round(area_under_curve(score, truth), 5) for score in (rule, net)
        ],
    }
    return TrainedClassifier(network, notes)


def region_scores(
    trials: Sequence[RegionTrial], network: Perceptron | None = None
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Return for all regions of trials what the rule and the network say, (n,) each, and which are altered."""
    rule = np.concatenate([-trial.log10_chance.min(axis=1) for trial in trials])
    net = distortion(np.concatenate([trial.features for trial in trials]), network)
    return rule, net, np.concatenate([trial.altered.any(axis=1) for trial in trials])


def area_under_curve(scores: FloatArray, truth: NDArray[np.bool_]) -> float:
    """Return the chance that a true one scores higher than a false one, ties as half (Mann-Whitney)."""
    true, false = int(truth.sum()), int((~truth).sum())
    if not true or not false:
        raise InputError("all of the scores are of one kind, expected true and false ones")
    return float((rankdata(scores)[truth].sum() - true * (true + 1) / 2.0) / (true * false))


def _table(trials: Sequence[RegionTrial]) -> Examples:
    """Return the features (n, d), gains (n,) of one, and targets (n,) of all halves of regions."""
    inputs = np.concatenate([trial.features.reshape(-1, trial.features.shape[-1]) for trial in trials])
    truth = np.concatenate([trial.altered.ravel() for trial in trials])
    return inputs, np.ones(len(inputs)), np.where(truth, 1.0, -1.0)
