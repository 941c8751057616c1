"""The soft demodulator against the rules it replaces, on held-out models.

python -m claims.demodulator [--folder models/test] [--most-points 20000] [--limit N] [--seed N]

Readings come after a lattice lock that succeeded. Columns: share of wrong signs, bits per carrier (mutual
information at the best scale of each rule, and in dB over the cosine), and the share of ids decoded when only a
part of the carriers is used: half of the carriers are 3 dB less energy. Readings in which the nearest points are
lost before the phase correction are left out.

No page quotes its figures yet; docs/claims.md says what it prints.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Callable, Sequence

import numpy as np

from claims.models import load, model_paths
from meshmark.errors import MeshmarkError
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.quantisation import log_likelihood_ratio
from meshmark.ownership.demodulator import demodulate
from meshmark.ownership.phase_correction import corrected_phase
from meshmark.research.training.demodulator_training import information, raw_errors
from meshmark.research.training.demodulator_trials import LOST, Marked, Trial, mark, trials

RULES: dict[str, Callable[[Trial], FloatArray]] = {
    "sign": lambda t: np.sign(np.cos(t.seen.phase)),
    "cosine": lambda t: np.cos(t.seen.phase),
    "wrapped normal": lambda t: log_likelihood_ratio(t.seen.phase),
    "corrected cosine": lambda t: np.cos(corrected_phase(t.seen)),
    "network": lambda t: demodulate(t.seen),
}
# Shares of the carriers that are decoded from; dB = 10 log10(share).
SHARES = (1.0, 0.79, 0.63, 0.5, 0.4, 0.32)
FEWER_ERRORS, DECIBELS = 0.20, 0.5


def decoded(marked: Marked, trial: Trial, soft: FloatArray, keep: FloatArray) -> bool:
    """Tell whether the id comes back from the carriers that are kept; pilots say nothing of it."""
    keep = keep[~trial.seen.keys.pilot[keep]]
    values = np.bincount(trial.seen.keys.code_index[keep], soft[keep], marked.codec.n)
    return marked.codec.decode(values).id == marked.identity


def measure(paths: Sequence, most_points: int, seed: int) -> list[tuple[str, Trial, dict[str, list[bool]]]]:
    """Mark, attack, read and decode every model."""
    rows = []
    for number, path in enumerate(paths):
        rng = np.random.default_rng([seed, number])
        try:
            mesh = load(path)
            marked = mark(mesh, rng) if len(mesh.vertices) <= most_points else None
            found = list(trials(marked, rng)) if marked else []
        except MeshmarkError as error:
            print(f"{path.name}: {error}", flush=True)
            continue
        for trial in found:
            order = rng.permutation(len(trial.seen))
            ids = {
                name: [
                    decoded(marked, trial, rule(trial), order[: int(share * len(order))]) for share in SHARES
                ]
                for name, rule in RULES.items()
            }
            rows.append((path.name, trial, ids))
        print(f"{path.name}: {len(found)} readings", flush=True)
    return rows


def report(rows: list[tuple[str, Trial, dict[str, list[bool]]]]) -> int:
    """Print the tables; exit 1 where the bar is missed."""
    groups: dict[str, list[int]] = defaultdict(list)
    saved: list[str] = []  # found by the phase correction only; the cosine would look too bad with them
    for i, (_, trial, _ids) in enumerate(rows):
        if raw_errors(np.cos(trial.seen.phase), trial.targets) > LOST:
            saved.append(f"{trial.attack}:{trial.strength:g}")
            continue
        groups[f"{trial.attack}:{trial.strength:g}"].append(i)
        if trial.attack.startswith(("noise", "smoothing")):
            groups["smoothing and noise"].append(i)
        groups["all"].append(i)
    soft = {name: [rule(trial) for _, trial, _ids in rows] for name, rule in RULES.items()}
    print("\n| attack | readings |", " | ".join(f"{name}: errors, bits, dB" for name in RULES), "|")
    print("|---|---|" + "---|" * len(RULES))
    bar = {}
    for group, index in groups.items():
        targets = np.concatenate([rows[i][1].targets for i in index])
        joined = {name: np.concatenate([values[i] for i in index]) for name, values in soft.items()}
        base = max(information(joined["cosine"], targets), 1e-6)
        cells = []
        for values in joined.values():
            bits, wrong = information(values, targets), raw_errors(values, targets)
            gain = 10.0 * np.log10(max(bits, 1e-6) / base)
            cells.append(f"{100 * wrong:.2f} %, {bits:.3f}, {gain:+.2f}")
        print(f"| {group} | {len(index)} |", " | ".join(cells), "|")
        bar[group] = (
            1.0 - raw_errors(joined["network"], targets) / max(raw_errors(joined["cosine"], targets), 1e-9),
            10.0 * np.log10(information(joined["network"], targets) / base),
        )
    print("\nids decoded, by share of the carriers used\n")
    print("| rule |", " | ".join(f"{share:g} ({10 * np.log10(share):+.1f} dB)" for share in SHARES), "|")
    print("|---|" + "---|" * len(SHARES))
    for name in RULES:
        rates = np.mean([rows[i][2][name] for i in groups["all"]], axis=0)
        print(f"| {name} |", " | ".join(f"{100 * rate:.1f} %" for rate in rates), "|")
    print(
        f"\nreadings that only the phase correction finds, left out: {len(saved)} ({', '.join(sorted(set(saved)))})"
    )
    fewer, gain = bar["smoothing and noise"]
    met = fewer >= FEWER_ERRORS or gain >= DECIBELS
    print(
        f"\nover smoothing and noise: {100 * fewer:.1f} % fewer errors and {gain:+.2f} dB against the cosine; "
        f"bar {100 * FEWER_ERRORS:.0f} % or {DECIBELS} dB: {'met' if met else 'MISSED'}"
    )
    return int(not met)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", default="models/test")
    parser.add_argument("--most-points", type=int, default=20_000)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    paths = list(model_paths(arguments.folder))[: arguments.limit]
    return report(measure(paths, arguments.most_points, arguments.seed))


if __name__ == "__main__":
    sys.exit(main())
