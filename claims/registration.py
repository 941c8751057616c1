"""How often a suspect is registered to within 1 %: `python -m claims.registration`.

[--folders models/train] [--limit N] [--smallest 5000] [--references certificate original] [--attacks none ...]

The plain model stands for the marked one. Each attack is made on it, and the result is read as it is and after a
random similarity. The truth is known, because these attacks leave the rest where it was: the error is the RMS
distance, over the suspect's vertices and in units of the model's scale, between the canonical coordinates that the
best starting frame gives and the true ones.

No page quotes its figures yet; docs/claims.md says what it prints.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
from collections import defaultdict
from collections.abc import Iterator
from time import perf_counter

import numpy as np

from claims.models import load, model_paths
from meshmark.attacks import find_attack, parse_chain
from meshmark.certificate.certify import certify
from meshmark.errors import MeshmarkError
from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.ownership.search.starting_frames import starting_frames

# Attack -> least share registered with the certificate, or None without a bar.
BARS = {
    "none": 1.0,
    "noise:0.01": 1.0,
    "noise:0.02": 0.95,
    "smoothing:50": 0.98,
    "smoothing_half:10": 0.95,
    "simplification:0.95": 0.95,
    "quantisation:7": 0.98,
    "remeshing:1": 1.0,
    "crop:0.09": 1.0,
    "crop:0.3": 1.0,
    "crop:0.5": 0.98,
    "crop:0.7": None,
    "crop:0.1+noise:0.003": 1.0,
}
GOOD, FINE = 0.01, 0.003
PLACINGS = ("as it is", "turned")
REFERENCES = ("certificate", "original")


def suspects(mesh: Mesh, attack: str, seed: int) -> Iterator[tuple[str, Mesh, Mesh]]:
    """Yield each placing of the attacked mesh, and where it would lie had it not been moved."""
    rng = np.random.default_rng(seed)
    attacked = parse_chain(attack)(mesh, rng)
    for placing, suspect in zip(
        PLACINGS, (attacked, find_attack("similarity")(attacked, 1.0, rng)), strict=True
    ):
        shuffled = rng.permutation(len(suspect.vertices))
        place = np.argsort(shuffled)
        yield (
            placing,
            Mesh(suspect.vertices[shuffled], place[suspect.faces]),
            Mesh(attacked.vertices[shuffled], place[attacked.faces]),
        )


def errors(frames: list[Frame], suspect: Mesh, unmoved: Mesh, home: Frame) -> list[float]:
    """Return the RMS distance from the truth of each frame."""
    truth = home.to_canonical(unmoved.vertices)
    return [
        float(np.sqrt(((frame.to_canonical(suspect.vertices) - truth) ** 2).sum(axis=1).mean()))
        for frame in frames
    ]


def main() -> int:
    """Measure and print; exit 1 where the certificate misses a bar."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folders", nargs="+", default=["models/train"])
    parser.add_argument("--limit", type=int)
    parser.add_argument("--smallest", type=int, default=5000, help="least number of points")
    parser.add_argument("--references", nargs="+", choices=REFERENCES, default=list(REFERENCES))
    parser.add_argument("--attacks", nargs="+", default=list(BARS))
    options = parser.parse_args()
    best: dict[tuple[str, str, str], list[list[float]]] = defaultdict(list)
    seconds: dict[tuple[str, str, str], list[float]] = defaultdict(list)
    models = ((path.name.split(".")[0], load(path)) for path in model_paths(*options.folders))
    large = ((name, mesh) for name, mesh in models if len(weld(mesh).points) >= options.smallest)
    for number, (name, mesh) in enumerate(large):
        if number == options.limit:
            break
        welded = weld(mesh)
        home = canonical_frame(welded.points, welded.faces)
        held = {"certificate": certify(mesh, 0.25, 0.05, "standard"), "original": mesh}
        missed = []
        for attack in options.attacks:
            seed = int.from_bytes(hashlib.sha256(f"{name} {attack}".encode()).digest()[:4], "little")
            try:
                placings = list(suspects(mesh, attack, seed))
            except MeshmarkError as error:
                print(f"{name}: {attack}: {error}")
                continue
            for placing, suspect, unmoved in placings:
                points = weld(suspect)
                for reference in options.references:
                    start = perf_counter()
                    frames = starting_frames(points, held[reference])
                    case = (attack, reference, placing)
                    seconds[case].append(perf_counter() - start)
                    best[case].append(found := errors(frames, suspect, unmoved, home))
                    if not found or found[0] > GOOD:
                        listed = ", ".join(f"{error:.3f}" for error in found) or "no frame"
                        missed.append(f"{attack} ({reference}, {placing}: {listed})")
        print(f"{name:28s} {len(welded.points):>6} points  {'; '.join(missed) or 'all'}", flush=True)
    return report(options.attacks, options.references, best, seconds)


def report(
    attacks: list[str],
    references: list[str],
    best: dict[tuple[str, str, str], list[list[float]]],
    seconds: dict[tuple[str, str, str], list[float]],
) -> int:
    """Print, per attack: models, shares within 1 % (first frame, any frame) and 0.3 %, median seconds."""
    missed = 0
    for reference in references:
        print(
            f"\n{reference}: first frame within 1 % / within 0.3 % / any frame within 1 % / median seconds\n"
        )
        print("| attack | models |", " | ".join(PLACINGS), "|")
        print("|---|---|" + "---|" * len(PLACINGS))
        for attack in attacks:
            cells = []
            for placing in PLACINGS:
                cases = best[attack, reference, placing]
                if not cases:
                    cells.append("-")
                    continue
                first = np.array([found[0] if found else np.inf for found in cases])
                nearest = np.array([min(found, default=np.inf) for found in cases])
                shares = [(first < GOOD).mean(), (first < FINE).mean(), (nearest < GOOD).mean()]
                listed = " / ".join(f"{100 * share:.0f} %" for share in shares)
                cells.append(f"{listed} / {np.median(seconds[attack, reference, placing]):.1f}")
                bar = BARS.get(attack) if reference == "certificate" else None
                missed += bar is not None and shares[2] < bar
            print(f"| {attack} | {len(best[attack, reference, PLACINGS[0]])} |", " | ".join(cells), "|")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
