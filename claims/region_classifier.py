"""The distortion classifier against the binomial rule, on held-out models.

python -m claims.region_classifier [--folder models/test] [--most-points 16000] [--edits N] [--limit N]

Each model is marked and edited locally in several ways. Columns: regions, and of these the altered ones; area
under the ROC curve of the rule and of the network; and at the network's threshold, and at the rule's of one in a
thousand, intact regions called altered and altered regions called intact.

Figures of docs/decisions/0010-layers-and-regions.md.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from claims.models import load, model_paths
from meshmark.errors import MeshmarkError
from meshmark.mesh import FloatArray
from meshmark.research.training.region_training import area_under_curve, region_scores
from meshmark.research.training.region_trials import RegionTrial, region_trials

LEAST_POINTS = 2000
RULE_THRESHOLD = 3.0
MOST_FALSE = 0.01


def measure(folder: str, most_points: int, edits: int, limit: int | None, seed: int) -> list[RegionTrial]:
    """Mark, edit and check every model of the folder."""
    found: list[RegionTrial] = []
    for number, path in enumerate(list(model_paths(folder))[:limit]):
        mesh = load(path)
        if not LEAST_POINTS <= len(mesh.vertices) <= most_points:
            continue
        try:
            trials = list(region_trials(mesh, np.random.default_rng([seed, number]), edits))
        except MeshmarkError as error:
            print(f"{path.name}: {error}", flush=True)
            continue
        unseen = [trial for trial in trials[1:] if not trial.home.any()]
        print(f"{path.name}: {len(trials)} edited models, {len(unseen)} not seen", flush=True)
        found += trials
    return found


def report(trials: Sequence[RegionTrial]) -> int:
    """Print the table; exit 1 where a bar is missed."""
    groups: dict[str, list[RegionTrial]] = defaultdict(list)
    for trial in trials:
        groups[trial.edit or "untouched"].append(trial)
        if trial.edit:
            groups[f"{100 * trial.share:g} % of the points"].append(trial)
    groups["all"] = list(trials)
    print(
        "\n| edits | regions | altered | AUC rule | AUC network | network: false, missed | rule: false, missed |"
    )
    print("|---|---|---|---|---|---|---|")
    for name, group in groups.items():
        rule, net, truth = region_scores(group)
        both = truth.any() and not truth.all()
        areas = [f"{area_under_curve(score, truth):.5f}" if both else "" for score in (rule, net)]
        home = np.concatenate([trial.home for trial in group])
        failed = np.concatenate([trial.features[:, :, 2].max(axis=1) > 0.0 for trial in group])
        cells = [_errors(net, 0.0, truth, failed, home), _errors(rule, RULE_THRESHOLD, truth, failed, home)]
        print(f"| {name} | {len(truth)} | {int(truth.sum())} |", " | ".join(areas + cells), "|")
    rule, net, truth = region_scores(trials)
    better = area_under_curve(net, truth) >= area_under_curve(rule, truth)
    home = np.concatenate([trial.home for trial in trials])
    false = float((((net > 0.0) | home) & ~truth)[~truth].mean())
    print(f"\nthe network at least as good as the rule: {'met' if better else 'MISSED'}")
    met = "met" if false <= MOST_FALSE else "MISSED"
    print(f"untouched regions called altered: {100 * false:.2f} %: {met}")
    return int(not better or false > MOST_FALSE)


def _errors(
    scores: FloatArray, threshold: float, truth: FloatArray, failed: FloatArray, home: FloatArray
) -> str:
    called = ((scores > threshold) & failed) | home
    false = 100.0 * float(called[~truth].mean()) if not truth.all() else 0.0
    missed = 100.0 * float((~called[truth]).mean()) if truth.any() else 0.0
    return f"{false:.2f} %, {missed:.1f} %"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", default="models/test")
    parser.add_argument("--most-points", type=int, default=16_000)
    parser.add_argument("--edits", type=int, default=8)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    return report(
        measure(arguments.folder, arguments.most_points, arguments.edits, arguments.limit, arguments.seed)
    )


if __name__ == "__main__":
    sys.exit(main())
