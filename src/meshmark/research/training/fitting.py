"""Fitting a perceptron to labelled examples, stopped by examples of models that were held out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshmark.errors import InputError
from meshmark.mesh import FloatArray
from meshmark.network.perceptron import Perceptron
from meshmark.research.training.levenberg_marquardt import Trained, levenberg_marquardt
from meshmark.research.training.losses import Objective, logistic

__all__ = ["Examples", "Recipe", "fitted", "held_out"]

Examples = tuple[FloatArray, FloatArray, FloatArray]
"""Features (n, d), gains (n,) and targets (n,), +1 or -1."""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """hidden: neurons of each hidden layer; ridge, passes, patience: of the training. starts: networks that are
    started from random weights, of which the best on the held-out examples is kept.
    """

    hidden: tuple[int, ...]
    ridge: float
    passes: int
    patience: int
    starts: int


def held_out(models: Mapping[str, Sequence[Any]], every: int) -> tuple[list[str], list[str]]:
    """Return the names of models to fit, and of every so-manieth, which is to say when to stop.

    Models without examples are left out. Raises `InputError` where none is left to fit.
    """
    names = sorted(name for name in models if models[name])
    held = names[::every]
    fit = [name for name in names if name not in held]
    if not fit:
        raise InputError(f"{len(names)} models could be marked and read, expected at least 2 to train on")
    return fit, held


def fitted(fit: Examples, held: Examples, recipe: Recipe, seed: int) -> tuple[Trained, Perceptron]:
    """Return the best network on the `held` examples, of some that were trained on the others."""
    runs = [_run(fit, held, recipe, [seed, start]) for start in range(recipe.starts)]
    return min(runs, key=lambda run: run[0].watched)


def _run(fit: Examples, held: Examples, recipe: Recipe, seed: Sequence[int]) -> tuple[Trained, Perceptron]:
    drawn = Perceptron.drawn(fit[0], recipe.hidden, np.random.default_rng(seed))
    goal, watch = (
        Objective(
            network=drawn,
            loss_of=logistic,
            inputs=inputs,
            gain=gain,
            targets=targets,
            shares=np.ones(len(inputs)),
            ridge=ridge,
        )
        for (inputs, gain, targets), ridge in ((fit, recipe.ridge), (held, 0.0))
    )
    found = levenberg_marquardt(
        goal.loss,
        goal.expand,
        drawn.weights,
        watch=watch.loss,
        passes=recipe.passes,
        patience=recipe.patience,
    )
    return found, drawn.with_weights(found.weights)
