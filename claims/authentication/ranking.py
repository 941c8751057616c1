"""Regions: how well the network and the binomial rule tell touched regions from untouched ones."""

from __future__ import annotations

from collections.abc import Iterator

from claims.authentication.figures import Row
from claims.authentication.subjects import Subject
from meshmark.research.training.region_training import region_scores
from meshmark.research.training.region_trials import region_trials

__all__ = ["EDITS", "measure"]

EDITS = 8
"""Local edits of each model."""


def measure(subject: Subject, draws: int | None) -> Iterator[Row]:
    """Yield the scores of every region of the model and of `draws` edits of it, and whether it was touched."""
    trials = list(region_trials(subject.mesh, subject.rng("ranking"), draws or EDITS))
    rule, network, touched = region_scores(trials)
    for figure, scores in (("ROC area of the network", network), ("ROC area of the binomial rule", rule)):
        for score, is_touched in zip(scores.tolist(), touched.tolist(), strict=True):
            yield Row(figure, subject.name, "touched" if is_touched else "untouched", score)
