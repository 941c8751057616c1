"""Draw the training curve of the rival deep3d: python tools/plot_deep3d.py CURVE.csv OUT.svg."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import matplotlib.pyplot as plt


def main(curve: Path, out: Path) -> None:
    """Plot the loss, and the share of wrong bits of the models kept aside, against the step."""
    plt.rcParams["svg.hashsalt"] = "meshmark"
    with curve.open(newline="") as file:
        rows = list(csv.DictReader(file))
    steps = [float(row["step"]) for row in rows]
    figure, (loss, errors) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
    loss.plot(steps, [float(row["message"]) for row in rows])
    loss.set(xlabel="step", ylabel="message loss, training", ylim=(0, None))
    for name in rows[0]:
        if name.startswith("aside_"):
            errors.plot(steps, [float(row[name]) for row in rows], label=name.removeprefix("aside_"))
    errors.set(xlabel="step", ylabel="wrong bits, models kept aside", ylim=(0, 0.5))
    errors.legend(fontsize="small", ncols=2)
    figure.savefig(out, metadata={"Date": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
