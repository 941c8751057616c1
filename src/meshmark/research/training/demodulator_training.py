"""Training of the soft demodulator on attacked models (docs/design.md, section 5; paper eq. 13-15)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.network.perceptron import Perceptron
from meshmark.ownership.carrier_features import carrier_features
from meshmark.ownership.carriers.quantisation import log_likelihood_ratio
from meshmark.ownership.demodulator import demodulate
from meshmark.ownership.phase_correction import corrected_phase
from meshmark.research.training.demodulator_trials import Trial
from meshmark.research.training.fitting import Examples, Recipe, fitted, held_out

__all__ = ["TrainedDemodulator", "figures", "information", "raw_errors", "train_demodulator"]

RECIPE: Final = Recipe(hidden=(8, 4), ridge=1e-4, passes=40, patience=6, starts=2)
# Every so-manieth model is for validation.
VALIDATION: Final = 3
_LARGEST_SCALE = 64.0


@dataclass(frozen=True, eq=False)
class TrainedDemodulator:
    """The network, and notes on how it was made and how good it is on the validation models."""

    network: Perceptron
    notes: dict[str, Any]


def train_demodulator(models: Mapping[str, Sequence[Trial]], seed: int) -> TrainedDemodulator:
    """Train on the trials of each model; every third model is held out to say when to stop.

    Raises `InputError` for fewer than two models.
    """
    names, held = held_out(models, VALIDATION)
    fit = [trial for name in names for trial in models[name]]
    validation = [trial for name in held for trial in models[name]]
    tables = _table(fit), _table(validation)
    found, network = fitted(*tables, RECIPE, seed)
    notes = {
        "seed": seed,
        "models for fitting": names,
        "models for validation": held,
        "readings": [len(fit), len(validation)],
        "carriers": [len(table[0]) for table in tables],
        "loss in nats": [round(found.loss, 5), round(found.watched, 5)],
        "figures on validation models": figures(validation, network),
    }
    return TrainedDemodulator(network, notes)


def figures(trials: Sequence[Trial], network: Perceptron) -> dict[str, dict[str, float]]:
    """Return per attack and over all: shares of wrong signs, and bits per carrier, of the rules and the network."""
    groups: dict[str, list[Trial]] = defaultdict(list)
    for trial in trials:
        groups[f"{trial.attack}:{trial.strength:g}"].append(trial)
    groups["all"] = list(trials)
    result = {}
    for name, group in groups.items():
        cosine, rule, net, targets = (
            np.concatenate(parts)
            for parts in (
                [np.cos(trial.seen.phase) for trial in group],
                [log_likelihood_ratio(trial.seen.phase) for trial in group],
                [demodulate(trial.seen, network) for trial in group],
                [trial.targets for trial in group],
            )
        )
        values = {
            "readings": float(len(group)),
            "errors nearest point": raw_errors(cosine, targets),
            "errors network": raw_errors(net, targets),
            "bits cosine": information(cosine, targets),
            "bits wrapped normal": information(rule, targets),
            "bits network": information(net, targets),
        }
        result[name] = {key: round(value, 4) for key, value in values.items()}
    return result


def raw_errors(soft: FloatArray, targets: FloatArray) -> float:
    """Return the share of soft values (n,) whose sign is not that of their target (n,): +1, -1, or 0 for none."""
    carries_bit = targets != 0.0
    return float(np.mean(soft[carries_bit] * targets[carries_bit] <= 0.0))


def information(soft: FloatArray, targets: FloatArray) -> float:
    """Return the bits per carrier that soft values (n,) tell of fair targets (n,), at their best common scale.

    targets: +1, -1, or 0 for a pilot, which carries no bit and is left out.
    """
    carries_bit = targets != 0.0
    agreement = soft[carries_bit] * targets[carries_bit]
    scales = np.geomspace(1.0 / _LARGEST_SCALE, _LARGEST_SCALE, 121)
    losses = [float(np.logaddexp(0.0, -scale * agreement).mean()) for scale in scales]
    return 1.0 - min(losses) / float(np.log(2.0))


def _table(trials: Sequence[Trial]) -> Examples:
    """Return the features (n, d), gains (n,) and targets (n,) of all carriers."""
    rows = []
    for trial in trials:
        seen = replace(trial.seen, phase=corrected_phase(trial.seen))
        carries_bit = trial.targets != 0.0  # pilots carry no bit
        rows.append(
            (carrier_features(seen)[carries_bit], np.cos(seen.phase[carries_bit]), trial.targets[carries_bit])
        )
    inputs, gain, targets = (np.concatenate(parts) for parts in zip(*rows, strict=True))
    return inputs, gain, targets
