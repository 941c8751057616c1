"""Attacks on a mark by people: with all the source, without the key.

    python -m claims.security NAME [--split test] [--models N] [--tries N] [--minutes M] [--seed N]
        [--least POINTS] [--most POINTS]

NAME is one of these.
pairs         20 originals with their marked copies and 50 marked models of a key: pose, phases, forgeries, removal
steering      a model warped until it has the label of a donor, whose mark is then forged on it
collusion     averages, medians, minima and maxima of 2, 3 and 5 copies
oracle        who may ask for the default JSON as often as he likes: removal, and the pose
forgeries     authentication marks forged without the key, in files of each tolerance, and of small models
steganalysis  whether a model is marked, by detectors that never saw the model

--models, --tries: how many, instead of as many as the bar asks for. --minutes: nothing further is begun after M
minutes. Prints a table; exits 1 where a bar is missed. What succeeds is named in docs/limits.md.

Figures of docs/results/security.md.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence
from time import monotonic

from claims.security.options import Options
from claims.security.table import Figure, table

__all__ = ["ATTACKS", "main"]

ATTACKS = ("pairs", "steering", "collusion", "oracle", "forgeries", "steganalysis")
"""Each a module of its name with a function of its name, (Options) -> some `Figure`."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one attack, print its table; exit 1 where a bar was missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("name", choices=ATTACKS)
    parser.add_argument("--split", default="train", choices=["train", "test"])
    parser.add_argument("--models", type=int)
    parser.add_argument("--tries", type=int)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--least", type=int, default=2500)
    parser.add_argument("--most", type=int, default=20_000)
    chosen = parser.parse_args(arguments)
    options = Options(
        split=chosen.split,
        models=chosen.models,
        tries=chosen.tries,
        seed=chosen.seed,
        least=chosen.least,
        most=chosen.most,
        end=monotonic() + 60.0 * chosen.minutes,
    )
    attack = getattr(importlib.import_module(f"claims.security.{chosen.name}"), chosen.name)
    figures: list[Figure] = []
    for figure in attack(options):
        print(figure, flush=True)
        figures.append(figure)
    print(table(figures))
    return int(any(row.met is False for row in figures))


if __name__ == "__main__":
    sys.exit(main())
