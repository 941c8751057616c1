"""How unlikely cells of unmarked models lock and agree with words under random keys, beside their bounds.

python -m claims.cell_locks [--minutes 8] [--models 40]

Training models of 2,500 to 60,000 points: cells are measured once for each, and read under one random key after
another with all quantisation steps. Printed: of how many readings the lock was as unlikely as 10^-k; and of the
likeliest step of one key in twenty, how often its bits agreed that well with the one word of a mark without an id,
and with the id that the bits are decoded to; beside the most that the bounds allow. Exits 1 where there were more
than that and its sampling error.

Figures of docs/results/false-positives.md.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from time import monotonic

import numpy as np

from claims.models import load, model_paths
from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.pose import Pose
from meshmark.ownership.carriers.quantisation import lock_score, log10_lock_chance
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import (
    CARRIER_MOST,
    CARRIER_READABLE,
    LONGEST_SAMPLE,
    STEPS,
    preferred_spacings,
)
from meshmark.ownership.search.measurement import Measurement, read_cells

LEAST, MOST = 2500, 60_000
FOLDERS = ("models/train", "psb/train")
# Bits are decoded for one key in so many: it takes longer than all else.
DECODED = 20
POWERS = range(2, 9)


@dataclass(frozen=True, eq=False, kw_only=True)
class Stored:
    """Cells of one model, and what is needed to read them under another key."""

    spacing: float
    label: Label
    cells: Cells


def stored(points_at_most: int, models: int) -> list[Stored]:
    """Measure the cells of the first models of the training folders that have enough."""
    found: list[Stored] = []
    key = Key(bytes(32))
    for path in model_paths(*FOLDERS):
        surface = surface_of(load(path))
        if not LEAST <= len(surface.points) <= points_at_most:
            continue
        frame = surface.frame
        spacing = preferred_spacings(frame.area)[0]
        label = Label.of_shape(surface.invariants, key)
        canonical = frame.to_canonical(surface.points)
        samples = plan_samples(canonical, surface.faces, LONGEST_SAMPLE * spacing)(canonical)
        cells = read_cells(samples, Lattice.keyed(key, spacing, label), Pose.turned(np.eye(3)))
        if CARRIER_READABLE <= len(cells.nodes) <= CARRIER_MOST:
            found.append(Stored(spacing=spacing, label=label, cells=cells))
        if len(found) == models:
            break
    return found


def read(each: Stored, key: Key) -> tuple[FloatArray, Reading]:
    """Return log10 of the chance of the lock at each step, and the reading at the likeliest."""
    measured = Measurement.of(Lattice.keyed(key, each.spacing, each.label), each.cells)
    phases = measured.phase(STEPS[:, None])
    keys = measured.keys
    scores = lock_score(keys.factor * phases, keys.weight)
    chances = np.array([log10_lock_chance(float(score), len(measured)) for score in scores])
    best = int(np.argmax(scores))
    reading = Reading(
        label=each.label,
        spacing=each.spacing,
        step=float(STEPS[best]),
        keys=keys,
        phase=phases[best],
        score=float(scores[best]),
        log10_chance=float(chances[best]),
        hypotheses=1.0,
    )
    return chances, reading


def table(name: str, chances: FloatArray) -> int:
    """Print how many are at most 10^-k, beside what the bound allows; return how often there are more."""
    print(f"{name}: {len(chances):,}, the least 10^{chances.min(initial=0.0):.1f}")
    missed = 0
    for power in POWERS:
        found, allowed = int((chances <= -power).sum()), len(chances) * 10.0**-power
        missed += found > allowed + 3.0 * np.sqrt(allowed) + 1.0
        print(f"  10^-{power}: {found:,} of at most {allowed:,.2f}")
    return missed


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; return 1 where a bound did not hold."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=8.0)
    parser.add_argument("--models", type=int, default=40)
    parser.add_argument("--most", type=int, default=MOST, help="points of a model, at most")
    options = parser.parse_args(arguments)
    models = stored(options.most, options.models)
    random = np.random.default_rng(1)
    locks: list[FloatArray] = []
    words: list[float] = []
    ids: list[float] = []
    end = monotonic() + 60.0 * options.minutes
    while models and monotonic() < end:
        for each in models:
            key = Key(random.bytes(32))
            chances, reading = read(each, key)
            locks.append(chances)
            if len(locks) % DECODED == 0:
                codec, observed = Codec(key), reading.observed()
                words.append(codec.presence_chance(observed))
                ids.append(codec.decode(observed).log10_chance)
    cells = [len(each.cells.nodes) for each in models]
    print(
        f"{len(models)} models, {min(cells, default=0)} to {max(cells, default=0)} cells, {len(locks):,} keys"
    )
    missed = table("readings, by their lock", np.concatenate([np.zeros(0), *locks]))
    missed += table("keys, by the word of a mark without an id", np.array(words))
    missed += table("keys, by the best of 2^64 ids", np.array(ids))
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
