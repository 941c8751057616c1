"""Write docs/results/ownership.md from the rows of `meshmark bench ownership`.

python tools/ownership_table.py own-out/results.csv "about the run" > docs/results/ownership.md
"""

from __future__ import annotations

import csv
import sys
from collections import defaultdict
from pathlib import Path

from meshmark.research.benchmark.figures.intervals import rate
from meshmark.research.benchmark.figures.labels import label

LARGE, MIDDLE = "> 20,000", "5,000-20,000"
TRUE = ("1", "True", "true")
# (scheme, size classes) of the columns, and what rate is asked for after each attack: large, middle, certificate.
COLUMNS = (("ncdg_lv", (LARGE,)), ("ncdg_lv", (MIDDLE,)), ("ncdg_lv_certificate", (LARGE, MIDDLE)))
BARS = {
    **dict.fromkeys(
        ("none", "similarity:1", "shuffle:1", "float32:1", "weld:1", "unweld:1"), (100, 100, 100)
    ),
    **dict.fromkeys(
        (f"file_{name}:1" for name in ("off", "obj", "ply", "stl", "glb", "gltf", "3mf")), (100, 100, 100)
    ),
    **dict.fromkeys(("noise:0.0005", "noise:0.001", "noise:0.003", "noise:0.005"), (100, 98, 100)),
    "noise:0.01": (98, 85, 100),
    "noise:0.02": (80, 40, 95),
    **dict.fromkeys(("smoothing:5", "smoothing:10", "smoothing:30"), (100, 95, 100)),
    "smoothing:50": (95, 60, 98),
    "smoothing_half:10": (90, None, 95),
    **dict.fromkeys(
        ("quantisation:11", "quantisation:10", "quantisation:9", "quantisation:8"), (100, 98, 100)
    ),
    "quantisation:7": (90, 70, 98),
    **dict.fromkeys(("midpoint:1", "loop:1", "sqrt3:1"), (100, 98, 100)),
    **dict.fromkeys(("simplification:0.5", "simplification:0.7", "simplification:0.9"), (100, 90, 100)),
    "simplification:0.95": (90, 60, 95),
    **dict.fromkeys(("remeshing:1", "voxels:256"), (95, 85, 100)),
    **dict.fromkeys(("crop:0.03", "crop:0.06", "crop:0.09"), (95, 85, 100)),
    "crop:0.3": (60, None, 100),
    "crop:0.5": (None, None, 98),
    "crop:0.1+noise:0.003+similarity:1": (85, None, 100),
    "affine:0.02": (90, 80, 100),
}


def cell(rows: list[dict[str, str]], bar: int | None) -> str:
    """Return "hits of models, rate (interval)", bold where it misses the bar."""
    hits, count = sum(row["recovered"] in TRUE for row in rows), len(rows)
    estimate = rate(hits, count)
    if estimate is None:
        return "not run"
    text = f"{hits}/{count} ({100 * estimate.low:.0f}-{100 * estimate.high:.0f} %)"
    if bar is None:
        return text
    return f"{text}, bar {bar} %" if 100 * hits >= bar * count else f"**{text}, bar {bar} %**"


def main() -> int:
    """Print the page."""
    path, about = Path(sys.argv[1]), sys.argv[2]
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    marked: dict[tuple[str, str, str], list[dict[str, str]]] = defaultdict(list)
    for row in rows:
        if row["trial"] == "marked":
            marked[row["attack"], row["scheme"], row["size_class"]].append(row)
    print("# What the mark survives: the ownership table\n")
    print(
        "Models whose exact 64-bit id comes back, of all models of the class; refused models are misses. In"
    )
    print(
        "brackets 95 % intervals (Clopper-Pearson). Bold: below the bar. Certificate: both classes together.\n"
    )
    print(about + "\n")
    print("| attack | > 20,000 points, blind | 5,000-20,000, blind | certificate |\n|---|---|---|---|")
    for attack, bars in BARS.items():
        cells = [
            cell([row for size in sizes for row in marked[attack, scheme, size]], bar)
            for (scheme, sizes), bar in zip(COLUMNS, bars, strict=True)
        ]
        print(f"| {label(attack)} | " + " | ".join(cells) + " |")
    nothing = [row for row in rows if row["trial"] != "marked" and row["status"] == "ok"]
    print(f"\nTrials with nothing to find (wrong keys and unmarked models): {len(nothing)}, found: ", end="")
    print(sum(row["present"] in TRUE for row in nothing))
    return 0


if __name__ == "__main__":
    sys.exit(main())
