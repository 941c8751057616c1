"""How visible marks are: the share of the surface where they show, the change of normals, the displacement.

    python -m claims.visible_share [--folder models/test] [--strengths subtle standard strong] [--layers both]

Prints a line for each model and strength, then the median and the worst of each strength, with what they are held
to; exits 1 where one is above. A model that is refused is named and counts for nothing.

Figures of docs/results/ownership.md.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
from collections.abc import Sequence

import numpy as np

from claims.models import load, model_paths
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import Visibility, VisibleChange
from meshmark.marking import embed
from meshmark.strengths import BUDGETS

# The median and the largest visible share, and the median change of normals (degrees) of the smoothest quarter.
BARS = {"subtle": (0.005, 0.03, np.inf), "standard": (0.03, 0.08, 1.3)}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; return 1 where a figure is above its bar."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--folder", default="models/test")
    parser.add_argument("--strengths", nargs="+", default=["subtle", "standard"], choices=list(BUDGETS))
    parser.add_argument("--layers", default="both", choices=["both", "ownership"])
    options = parser.parse_args(arguments)
    found: dict[str, list[tuple[Visibility, float]]] = {strength: [] for strength in options.strengths}
    for path in model_paths(options.folder):
        mesh = load(path)
        surface = surface_of(mesh)
        seen = VisibleChange(surface.points, surface.faces)
        for strength in options.strengths:
            key = Key(hashlib.sha256(path.name.encode()).digest())
            try:
                made = embed(mesh, key, id=1, strength=strength, layers=options.layers)
            except CapacityError as error:
                print(f"{path.name:32s} {strength:9s} refused: {error}", flush=True)
                continue
            shown = seen.of(made.mesh.vertices[surface.vertex_of_point])
            found[strength].append((shown, made.rms_over_diagonal))
            print(
                f"{path.name:32s} {strength:9s} visible {100 * shown.share:5.1f} %, "
                f"ratio {shown.median:.2f} median "
                f"{shown.p95:.2f} 95 %, smooth quarter {shown.smooth:.2f} degrees, "
                f"RMS {100 * made.rms_over_diagonal:.4f} %",
                flush=True,
            )
    return max([_summary(strength, each) for strength, each in found.items() if each], default=0)


def _summary(strength: str, found: Sequence[tuple[Visibility, float]]) -> int:
    shares = [shown.share for shown, _ in found]
    smooth = [shown.smooth for shown, _ in found]
    figures = float(np.median(shares)), max(shares), float(np.median(smooth))
    print(
        f"{strength}, {len(found)} models: visible share {100 * figures[0]:.1f} % median, "
        f"{100 * figures[1]:.1f} % worst; "
        f"smooth quarter {figures[2]:.2f} degrees median, {max(smooth):.2f} worst; "
        f"RMS {100 * max(rms for _, rms in found):.4f} % worst"
    )
    return int(any(figure > bar for figure, bar in zip(figures, BARS.get(strength, ()), strict=False)))


if __name__ == "__main__":
    sys.exit(main())
