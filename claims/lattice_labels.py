"""How well a model's lattice label survives attacks: `python -m claims.lattice_labels --samples FILE.npz`.

Invariants of all models of psb/train, and their changes by the attacks of
`meshmark/research/training/label_trials.py` for models of 2,500 to 40,000 points: all of models/train, every
third of psb/train. They are kept in FILE.npz, and read from there the next time. Prints Markdown for
docs/decisions/0020-one-lattice-per-model.md: the shipped map attack by attack, and with `--trade` maps of other
sizes, each fitted to one half of the models and judged on the other. `--fit OUT.json` writes a map fitted to all
of them, and prints its figures instead: that is how src/meshmark/ownership/carriers/label_map.json was made.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from claims.models import load, model_paths
from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.geometry.invariants import shape_invariants
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.lattice_label import LabelMap, dump_map, labels, shipped_map
from meshmark.research.training.label_training import collision, fit_label_map
from meshmark.research.training.label_trials import MODERATE, Drift, drifts

LEAST, MOST = 2_500, 40_000
EVERY = 3  # of the models of psb/train that are large enough
# Six digits are kept of the map; the chance that models share a label is a little below 2^-12.
COMPONENTS, SHARED_LOG2, DIGITS = 6, -12.2, 6
TRADES = ((4, -12.0), (5, -12.0), (6, -12.0), (7, -12.0), (8, -12.0), (6, -10.0), (6, -13.0), (6, -14.0))
# Drifts of a frame that no lattice lock bridges: the mark is lost whatever its label.
REACH: Final = 0.1
KEYS = 10
COLUMNS = ("first", "within 4", "within 16", "first, as it stands", "within 4, as it stands")


@dataclass(frozen=True, eq=False, kw_only=True)
class Sample:
    """A model under an attack: its folder and name, its invariants before, and what the attack changed."""

    model: str
    truth: FloatArray
    drift: Drift


def population() -> FloatArray:
    """Return the invariants of all models of psb/train that have a surface."""
    rows = []
    for path in model_paths("psb/train"):
        with suppress(MeshmarkError):
            surface = weld(load(path))
            rows.append(shape_invariants(surface.points, surface.faces))
    return np.array(rows)


def samples(limit: int | None) -> list[Sample]:
    """Attack the models."""
    found = []
    for folder, every in (("models/train", 1), ("psb/train", EVERY)):
        used = 0
        for path in model_paths(folder):
            with suppress(MeshmarkError):
                mesh = load(path)
                surface = weld(mesh)
                if not LEAST <= len(surface.points) <= MOST:
                    continue
                used += 1
                if (used - 1) % every or (limit is not None and used > limit * every):
                    continue
                truth = shape_invariants(surface.points, surface.faces)
                rng = np.random.default_rng([0, used])
                name = f"{folder}/{path.name}"
                found += [Sample(model=name, truth=truth, drift=drift) for drift in drifts(mesh, rng)]
                print(name, len(surface.points), flush=True)
    return found


def kept(file: Path, limit: int | None) -> tuple[FloatArray, list[Sample]]:
    """Return population and samples, from the file where there is one."""
    if not file.exists():
        models, made = population(), samples(limit)
        np.savez(
            file,
            models=models,
            names=[sample.model for sample in made],
            truths=[sample.truth for sample in made],
            attacks=[sample.drift.attack for sample in made],
            strengths=[sample.drift.strength for sample in made],
            changes=[sample.drift.change for sample in made],
        )
    with np.load(file) as held:
        columns = (held[name] for name in ("names", "truths", "attacks", "strengths", "changes"))
        found = [
            Sample(
                model=str(name),
                truth=truth,
                drift=Drift(attack=str(attack), strength=float(strength), change=change),
            )
            for name, truth, attack, strength, change in zip(*columns, strict=True)
        ]
        return held["models"], found


def hits(sample: Sample, label_map: LabelMap, keys: Sequence[Key]) -> FloatArray:
    """Return the shares of keys (5,) whose label is found, in the order of COLUMNS."""
    rows = []
    for key in keys:
        true = labels(sample.truth, key, 1, label_map)[0]
        lists = [labels(sample.truth + row, key, 16, label_map) for row in sample.drift.change]
        ranks = [found.index(true) if true in found else len(found) for found in lists]
        best, plain = min(ranks), ranks[0]
        rows.append([best < 1, best < 4, best < 16, plain < 1, plain < 4])
    return np.asarray(np.mean(rows, axis=0))


def tried(some: Sequence[Sample], label_map: LabelMap, most: int) -> float:
    """Return how many different labels all restorations of a sample have together, on average."""
    key = _keys()[0]
    found = [
        {label for row in sample.drift.change for label in labels(sample.truth + row, key, most, label_map)}
        for sample in some
    ]
    return float(np.mean([len(each) for each in found]))


def groups(some: Sequence[Sample]) -> dict[str, list[int]]:
    """Return which samples are of models or polygon soups, moderate or strong; lost ones apart."""
    parts: dict[str, list[int]] = {}
    for number, sample in enumerate(some):
        if sample.drift.frame_change > REACH:
            continue
        moderate = (sample.drift.attack, sample.drift.strength) in MODERATE
        name = f"{sample.model.split('/')[0]} {'moderate' if moderate else 'strong'}"
        parts.setdefault(name, []).append(number)
    return dict(sorted(parts.items()))


def fitted(models: FloatArray, some: Sequence[Sample], components: int, shared_log2: float) -> LabelMap:
    """Return the map fitted to the samples that are not lost."""
    changes = [sample.drift.change for sample in some if sample.drift.frame_change <= REACH]
    exact = fit_label_map(models, changes, components, 2.0**shared_log2).matrix
    return LabelMap(np.array([[float(f"{x:.{DIGITS}g}") for x in row] for row in exact]))


def bin_width(some: Sequence[Sample], label_map: LabelMap) -> float:
    """Return how wide bins are against the drift that two thirds of the samples in reach stay below."""
    places = [sample.drift.change @ label_map.matrix for sample in some if sample.drift.frame_change <= REACH]
    nearest = [rows[np.argmin((rows**2).sum(axis=1))] for rows in places]
    return float(1.0 / np.median(np.quantile(np.abs(nearest), 0.68, axis=0)))


def cross_judged(
    models: FloatArray, some: Sequence[Sample], components: int, shared_log2: float
) -> tuple[FloatArray, float]:
    """Return the hits of all samples (n, 5), each by the map of the other half of the models; mean collision."""
    names = sorted({sample.model for sample in some})
    side = {name: number % 2 for number, name in enumerate(names)}
    keys = _keys()
    result, chances = np.zeros((len(some), len(COLUMNS))), []
    for half in (0, 1):
        others = [sample for sample in some if side[sample.model] != half]
        label_map = fitted(models, others, components, shared_log2)
        chances.append(collision(models @ label_map.matrix, np.random.default_rng(1)))
        for number, sample in enumerate(some):
            if side[sample.model] == half:
                result[number] = hits(sample, label_map, keys)
    return result, float(np.mean(chances))


def trade_table(models: FloatArray, some: Sequence[Sample]) -> None:
    """Print the hits of maps of several sizes."""
    parts = groups(some)
    print(f"| components | bin | shared | {' | '.join(f'{part}: first / 4 / 16' for part in parts)} |")
    print("|" + "---|" * (3 + len(parts)))
    for components, shared in TRADES:
        found, chance = cross_judged(models, some, components, shared)
        cells = [
            " / ".join(f"{100 * x:.1f}" for x in found[index].mean(axis=0)[:3]) for index in parts.values()
        ]
        wide = bin_width(some, fitted(models, some, components, shared))
        print(f"| {components} | {wide:.0f} | 2^{np.log2(chance):.1f} | {' | '.join(cells)} |", flush=True)


def attack_table(models: FloatArray, some: Sequence[Sample], label_map: LabelMap) -> None:
    """Print the hits of one map, attack by attack."""
    chance = collision(models @ label_map.matrix, np.random.default_rng(1))
    print(
        f"\nShared by two models of psb/train: 2^{np.log2(chance):.1f}. Different labels of all restorations"
    )
    counts = ", ".join(f"{most}: {tried(some, label_map, most):.1f}" for most in (1, 4))
    print(f"together, on average, by the number that each has: {counts}.\n")
    keys = _keys()
    found = np.array([hits(sample, label_map, keys) for sample in some])
    print(f"| attack | family | in reach | {' | '.join(COLUMNS)} |")
    print("|" + "---|" * (3 + len(COLUMNS)))
    kinds = dict.fromkeys((sample.drift.attack, sample.drift.strength) for sample in some)
    for family in ("models", "psb"):
        for name, strength in kinds:
            of_kind = [
                number
                for number, sample in enumerate(some)
                if (sample.drift.attack, sample.drift.strength) == (name, strength)
                and sample.model.startswith(family)
            ]
            held = [number for number in of_kind if some[number].drift.frame_change <= REACH]
            shares = " | ".join(f"{100 * x:.1f}" for x in found[held].mean(axis=0))
            print(f"| {name} {strength:g} | {family} | {len(held)} of {len(of_kind)} | {shares} |")


def _keys() -> list[Key]:
    rng = np.random.default_rng(3)
    return [Key(rng.bytes(32)) for _ in range(KEYS)]


def main() -> None:
    """Make or read the samples, fit, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=Path, required=True, help="where the samples are kept (.npz)")
    parser.add_argument("--fit", type=Path, metavar="OUT.json", help="write a map fitted to all samples")
    parser.add_argument("--trade", action="store_true", help="print the table of other sizes")
    parser.add_argument("--limit", type=int, help="attack only so many models of each folder")
    given = parser.parse_args()
    models, some = kept(given.samples, given.limit)
    lost = sum(sample.drift.frame_change > REACH for sample in some)
    print(f"{len(models)} models of psb/train; {len(some)} attacked, of them out of reach {lost}\n")
    if given.trade:
        trade_table(models, some)
    label_map = shipped_map() if given.fit is None else fitted(models, some, COMPONENTS, SHARED_LOG2)
    if given.fit is not None:
        notes = {"command": f"python -m claims.lattice_labels --samples FILE.npz --fit {given.fit.name}"}
        given.fit.write_text(dump_map(label_map, notes), "utf-8")
    attack_table(models, some, label_map)


if __name__ == "__main__":
    main()
