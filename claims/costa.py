"""How far the mark is from the Costa capacity, in dB, by size class, from the rows of a benchmark run.

python -m claims.costa own-out/results.csv [--data ../shared/data/models/test]

A mark of power W in N vertices under noise of power Z can carry 0.5 N log2(1 + W / Z) bits, even if its reader
does not know the host (Costa 1983, doi:10.1109/TIT.1983.1056659). For 64 bits W / Z must be 2^(128 / N) - 1 at
least. The distance is the W / Z at which a model was last read exactly, over that: the strongest noise attack it
survived. Only displacement along normals counts, so of the noise a third; the mark is taken to lie along normals.

Figures of docs/results/ownership.md.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

from claims.models import DATA, load
from meshmark.attacks.moved_vertices import mean_radius

BITS = 64


def distance_db(points: int, mark: float, noise: float) -> float:
    """Return the distance to capacity in dB; mark, noise: RMS along normals in the same unit."""
    needed = 2.0 ** (2.0 * BITS / points) - 1.0
    return float(10.0 * np.log10((mark / noise) ** 2 / needed))


def radius_over_diagonal(path: Path) -> float:
    """Return the mean distance of a model's vertices from their centroid, by which noise is measured."""
    mesh = load(path)
    return float(mean_radius(mesh) / np.linalg.norm(np.ptp(mesh.vertices, axis=0)))


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path)
    parser.add_argument("--data", type=Path, default=DATA / "models" / "test")
    arguments = parser.parse_args()
    strongest: dict[tuple[str, str], dict[str, tuple[float, int, float]]] = defaultdict(dict)
    with arguments.results.open(newline="") as file:
        for row in csv.DictReader(file):
            name, _, strength = row["attack"].partition(":")
            if name != "noise" or row["trial"] != "marked" or row["recovered"] not in ("1", "True", "true"):
                continue
            held = strongest[row["scheme"], row["size_class"]]
            before = held.get(row["model"], (0.0, 0, 0.0))
            new = (float(strength), int(float(row["points"])), float(row["rms_over_diagonal"] or "nan"))
            held[row["model"]] = max(before, new)
    print("scheme                size class      models  dB from capacity: median (least, most)")
    for (scheme, size), models in sorted(strongest.items()):
        distances = []
        for model, (strength, points, rms) in models.items():
            noise = strength * radius_over_diagonal(arguments.data / model) / np.sqrt(3.0)
            distances.append(distance_db(points, rms, noise))
        middle, least, most = np.nanmedian(distances), np.nanmin(distances), np.nanmax(distances)
        print(f"{scheme:20s}  {size:14s}  {len(models):6d}  {middle:.1f} ({least:.1f}, {most:.1f})")
    return 0


if __name__ == "__main__":
    sys.exit(main())
