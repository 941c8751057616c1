"""How unlikely the locks of points of unmarked models get under random keys, beside what their bound claims.

python -m claims.point_locks [--minutes 8] [--models 40]

Princeton training models of 40 to 2,500 points, each under one random key after another, in its own frame
and read with all choices of step, mode and share. Printed: how many readings there were, and of how many frames
the best choice was as unlikely as 10^-k, beside the most that the bound allows; exits 1 where there were more than
that and its sampling error.

Figures of docs/results/coarse.md.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from time import monotonic

import numpy as np

from claims.models import DATA, load
from claims.princeton import models_of
from meshmark.coding.keys import Key
from meshmark.geometry.surface_of import surface_of
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_reading import CHOICES, Framed

LEAST, MOST = 40, 2500


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; return 1 where the bound did not hold."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=8.0)
    parser.add_argument("--models", type=int, default=40)
    options = parser.parse_args(arguments)
    surfaces = []
    for model in models_of(["train"]):
        surface = surface_of(load(DATA / model))
        if LEAST <= len(surface.points) <= MOST:
            surfaces.append((surface, Carried.of(surface, surface.frame)))
        if len(surfaces) == options.models:
            break
    random = np.random.default_rng(1)
    best: list[float] = []
    end = monotonic() + 60.0 * options.minutes
    while monotonic() < end:
        for surface, carried in surfaces:
            key = Key(random.bytes(32))
            lattice = PointLattice.keyed(key, Label.of_shape(surface.invariants, key))
            framed = Framed.of(surface, carried, surface.frame, lattice)
            readings = (framed.reading(lock.choice, 1.0) for lock in framed.locks())
            best.append(min((reading.log10_chance for reading in readings), default=0.0))
    print(f"{len(best):,} frames of {len(surfaces)} models, {len(best) * CHOICES:,} readings")
    missed = 0
    for power in range(3, 9):
        found, allowed = sum(each <= -power for each in best), len(best) * CHOICES * 10.0**-power
        missed += found > allowed + 3.0 * np.sqrt(allowed) + 1.0
        print(f"10^-{power}: {found:,} of at most {allowed:,.2f}")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
