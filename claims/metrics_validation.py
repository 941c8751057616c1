"""MSDM2 and surface distances against the reference values of ../shared/data/msdm2, pair by pair.

python -m claims.metrics_validation [--pairs bimba cow_simp50 ...]

Exit 1 where a value is outside its tolerance: MSDM2 3e-4 (cow 2e-3), distances 2 %.

Figures of docs/decisions/0005-metrics.md.
"""

from __future__ import annotations

import argparse
import json
import lzma
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from claims.models import DATA
from meshmark.io import read_mesh
from meshmark.mesh import Mesh
from meshmark.metrics.msdm2 import msdm2, msdm2_map
from meshmark.metrics.surface_distance import surface_distances

FOLDER = DATA / "msdm2"


def read(name: str) -> Mesh:
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / name.removesuffix(".xz")
        plain.write_bytes(lzma.decompress((FOLDER / name).read_bytes()))
        return read_mesh(plain)


def measured(pair: str, values: dict[str, float | str]) -> Iterator[tuple[str, float, float, float]]:
    """Yield (what, reference, ours, tolerance) of one pair."""
    a, b = read(str(values["original"])), read(str(values["degraded"]))
    tolerance = 2e-3 if pair.startswith("cow") else 3e-4
    yield "msdm2", float(values["msdm2"]), msdm2(a, b), tolerance
    yield "msdm2_reverse", float(values["msdm2_reverse"]), msdm2(b, a), tolerance
    found = surface_distances(a, b)
    diagonal = float(values["diagonal"])
    for name in ("rms_ab", "rms_ba", "hausdorff_ab", "hausdorff_ba"):
        reference = float(values[name])
        yield (
            name + " / D",
            reference / diagonal,
            getattr(found, name) / diagonal,
            0.02 * reference / diagonal,
        )
    for name, larger in (("rms", "MRMS / D"), ("hausdorff", "Hausdorff / D")):
        reference = max(float(values[f"{name}_ab"]), float(values[f"{name}_ba"])) / diagonal
        ours = max(getattr(found, f"{name}_ab"), getattr(found, f"{name}_ba")) / diagonal
        yield larger, reference, ours, 0.02 * reference
    reference = 0.5 * (float(values["rms_ab"]) + float(values["rms_ba"])) / diagonal
    yield "mean RMS / D", reference, 0.5 * (found.rms_ab + found.rms_ba) / diagonal, 0.02 * reference
    for name, ours in (("rms_ab", found.area_rms_ab), ("rms_ba", found.area_rms_ba)):
        reference = float(values[f"{name}_faces_only"]) / diagonal
        yield f"{name} faces / D", reference, ours / diagonal, 0.02 * reference


def local_map() -> Iterator[tuple[str, float, float, float]]:
    """Yield how far the map of bimba is from the reference map: all but ties of closest points agree."""
    a, b = read("bimba_original.off.xz"), read("bimba_deformed.obj.xz")
    for x, y, name in ((a, b, "bimba_msdm2"), (b, a, "bimba_msdm2_reverse")):
        apart = np.abs(msdm2_map(x, y) - np.load(FOLDER / f"{name}_pervertex.npy"))
        yield f"{name} map, median", 0.0, float(np.median(apart)), 1e-12
        yield f"{name} map, 99 %", 0.0, float(np.quantile(apart, 0.99)), 0.02


def main() -> int:
    """Print every value; exit 1 on a miss."""
    values = json.loads((FOLDER / "values.json").read_text())
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", nargs="+", choices=values, default=list(values))
    pairs = parser.parse_args().pairs
    print("| pair | value | reference | ours | difference | tolerance | |")
    print("|---|---|---|---|---|---|---|")
    missed, start = 0, time.process_time()
    for pair in pairs:
        rows = list(measured(pair, values[pair])) + (list(local_map()) if pair == "bimba" else [])
        for what, reference, ours, tolerance in rows:
            fine = abs(ours - reference) <= tolerance
            missed += not fine
            print(
                f"| {pair} | {what} | {reference:.6g} | {ours:.6g} | {ours - reference:+.1e} | {tolerance:.1e} | "
                f"{'ok' if fine else 'MISSED'} |",
                flush=True,
            )
    print(f"\n{missed} missed, {time.process_time() - start:.0f} s of processor time")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
