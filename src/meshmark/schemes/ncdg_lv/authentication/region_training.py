"""Training of the distortion classifier on locally edited models (DESIGN section 5; paper eq. 13-15)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from meshmark.errors import InputError
from meshmark.mesh import FloatArray
from meshmark.network.levenberg_marquardt import Trained, levenberg_marquardt
from meshmark.network.losses import Objective, logistic
from meshmark.network.perceptron import Perceptron
from meshmark.schemes.ncdg_lv.authentication.region_classifier import distortion
from meshmark.schemes.ncdg_lv.authentication.region_trials import RegionTrial

__all__ = ["TrainedClassifier", "area_under_curve", "region_scores", "train_classifier"]

HIDDEN: Final = (8, 4)
RIDGE: Final = 1e-4
PASSES: Final = 80
PATIENCE: Final = 10
# Networks are started from so many random weights; the best on the validation models is kept.
STARTS: Final = 4
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
    names = sorted(name for name in models if models[name])
    held = names[::VALIDATION]
    fitted = [name for name in names if name not in held]
    if not fitted:
        raise InputError(f"{len(names)} models could be marked and checked, expected at least 2 to train on")
    fit = [trial for name in fitted for trial in models[name]]
    validation = [trial for name in held for trial in models[name]]
    runs = [_run(_table(fit), _table(validation), [seed, start]) for start in range(STARTS)]
    found, network = min(runs, key=lambda run: run[0].watched)
    rule, net, truth = region_scores(validation, network)
    notes = {
        "seed": seed,
        "models for fitting": fitted,
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


def _run(
    fit: tuple[FloatArray, FloatArray], watched: tuple[FloatArray, FloatArray], seed: Sequence[int]
) -> tuple[Trained, Perceptron]:
    """Train on the first table from weights drawn with this seed, stopped by the second."""
    drawn = Perceptron.drawn(fit[0], HIDDEN, np.random.default_rng(seed))
    goal, watch = (
        Objective(drawn, logistic, inputs, np.ones(len(inputs)), targets, np.ones(len(inputs)), ridge)
        for (inputs, targets), ridge in ((fit, RIDGE), (watched, 0.0))
    )
    found = levenberg_marquardt(
        goal.loss, goal.expand, drawn.weights, watch=watch.loss, passes=PASSES, patience=PATIENCE
    )
    return found, drawn.with_weights(found.weights)


def _table(trials: Sequence[RegionTrial]) -> tuple[FloatArray, FloatArray]:
    """Return the features (n, d) and targets (n,), +1 or -1, of all halves of regions."""
    inputs = np.concatenate([trial.features.reshape(-1, trial.features.shape[-1]) for trial in trials])
    truth = np.concatenate([trial.altered.ravel() for trial in trials])
    return inputs, np.where(truth, 1.0, -1.0)
