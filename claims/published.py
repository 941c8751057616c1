"""Bit errors of the 64-bit id beside the published figures of the mesh watermarking benchmark, at both budgets.

python -m claims.published [--least 45000] [--most 56000] [--folder models/test] [--limit N]
                               [--budgets standard subtle]

Models about as large as Venus. Read blind; a mark that is refused or not found counts as 0.5. Bold: above the
better of the two published columns.

Figures of docs/results/published.md.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict

import numpy as np

from claims.models import load, model_paths
from meshmark.attacks import parse_chain
from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.research import SCHEMES
from meshmark.research.benchmark.figures.labels import label

# Venus, 64 bits: Cho, Prost, Jung 2007 at 0.008 % MRMS, volume moments 2011 at 0.069 %: docs/design.md, section 11.
PUBLISHED = {
    "noise:0.0005": (0.01, 0.0),
    "noise:0.001": (0.03, 0.01),
    "noise:0.003": (0.13, 0.08),
    "noise:0.005": (0.28, 0.16),
    "smoothing:5": (0.10, 0.0),
    "smoothing:10": (0.23, 0.01),
    "smoothing:30": (0.38, 0.07),
    "smoothing:50": (0.45, 0.14),
    "quantisation:11": (0.0, 0.0),
    "quantisation:10": (0.04, 0.01),
    "quantisation:9": (0.14, 0.01),
    "quantisation:8": (0.26, 0.05),
    "quantisation:7": (0.46, 0.17),
    "midpoint:1": (0.04, 0.0),
    "sqrt3:1": (0.14, 0.0),
    "loop:1": (0.16, 0.0),
}
SIZES = {"standard": "0.08 %", "subtle": "0.02 %"}
LOST = 0.5


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", default="models/test")
    parser.add_argument("--least", type=int, default=45_000)
    parser.add_argument("--most", type=int, default=56_000)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--budgets", nargs="+", choices=tuple(SIZES), default=list(SIZES))
    arguments = parser.parse_args()
    scheme = SCHEMES["ncdg_lv"]
    errors: dict[tuple[str, str], list[float]] = defaultdict(list)
    used: list[str] = []
    for path in model_paths(arguments.folder):
        mesh = load(path)
        if not arguments.least <= len(mesh.vertices) <= arguments.most or len(used) == arguments.limit:
            continue
        used.append(f"{path.name.split('.')[0]} ({len(mesh.vertices):,} points)")
        rng = np.random.default_rng(len(used))
        key, bits = Key(rng.bytes(32)), rng.integers(0, 2, scheme.bits).astype(np.uint8)
        for budget in arguments.budgets:
            try:
                marked = scheme.embed(mesh, bits, key, strength=budget)
            except MeshmarkError:
                marked = None
            for case in PUBLISHED:
                error = LOST
                if marked is not None:
                    read = scheme.extract(parse_chain(case)(marked, rng), key)
                    error = float(np.mean(read.bits != bits)) if read.present else LOST
                errors[case, budget].append(error)
                print(f"{path.name:36s} {budget:9s} {case:16s} {error:.3f}", file=sys.stderr, flush=True)
    print(f"Models: {', '.join(used)}.\n")
    heads = " | ".join(f"here, {SIZES[budget]} RMS" for budget in arguments.budgets)
    print(f"| attack | Cho 2007, 0.008 % | moments 2011, 0.069 % | {heads} |")
    print("|" + "---|" * (3 + len(arguments.budgets)))
    for case, claimed in PUBLISHED.items():
        means = [float(np.mean(errors[case, budget])) for budget in arguments.budgets]
        cells = [f"{mean:.3f}" if mean <= min(claimed) else f"**{mean:.3f}**" for mean in means]
        print(f"| {label(case)} | {claimed[0]:g} | {claimed[1]:g} | {' | '.join(cells)} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
