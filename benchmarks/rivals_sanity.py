"""Rivals beside what is published of them, on models of about 50,000 points.

    python -m benchmarks.rivals_sanity [NAMES OF TEST MODELS]

cho_mean  as published (64 bins, no pilots) at the distortion of the mesh watermarking benchmark, 0.008 % MRMS,
          beside its figures for Venus (DESIGN section 11), and at our two budgets; bit errors, the mean over keys.
          Bars: clean 0; noise 0.5 % between 0.1 and 0.4; smoothing 50 passes and quantisation 7 bits above 0.3.
lsb       clean 0, and chance (0.4 to 0.6) after a float32 re-encode or a similarity.
mdaqim    reads after any rotation, scale and shift; its units verify, and those in an altered place do not.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np

from benchmarks.models import DATA, load
from benchmarks.published import PUBLISHED as BOTH
from meshmark.attacks.chain import parse_chain
from meshmark.coding.keys import Key
from meshmark.mesh import Mesh
from meshmark.metrics.surface_distance import mrms_over_diagonal
from meshmark.schemes.rivals.cho import ChoMean
from meshmark.schemes.rivals.host import Host
from meshmark.schemes.rivals.lsb import Lsb
from meshmark.schemes.rivals.mdaqim import Mdaqim
from meshmark.schemes.rivals.rival import Rival

MODELS = ("hand_50085", "feline_49864")
KEYS = [Key(bytes([number]) * 32) for number in range(2)]
PUBLISHED_MRMS = 8e-5
PUBLISHED = {"none": 0.0, **{chain: cho for chain, (cho, _) in BOTH.items()}}
BARS: dict[str, tuple[float, float]] = {
    "none": (0.0, 0.0),
    "noise:0.005": (0.1, 0.4),
    "smoothing:50": (0.3, 1.0),
    "quantisation:7": (0.3, 1.0),
}
CHANCE = (0.4, 0.6)


def attacked(mesh: Mesh, chain: str, seed: int) -> Mesh:
    return mesh if chain == "none" else parse_chain(chain)(mesh, np.random.default_rng(seed))


def payload(seed: int) -> np.ndarray[tuple[int], np.dtype[np.uint8]]:
    return np.random.default_rng(seed).integers(0, 2, 64, dtype=np.uint8)


def errors(scheme: Rival, marked: list[Mesh], chain: str) -> float:
    """Return the mean share of wrong bits over the keys."""
    rates = []
    for seed, (key, mesh) in enumerate(zip(KEYS, marked, strict=True)):
        found = scheme.extract(attacked(mesh, chain, seed), key)
        rates.append(np.mean(found.bits != payload(seed)))
    return float(np.mean(rates))


def cho(mesh: Mesh) -> bool:
    scheme = ChoMean(pilots=0)

    def marks(budget: float) -> list[Mesh]:
        return [scheme.marked(mesh, payload(seed), key, budget) for seed, key in enumerate(KEYS)]

    trial = scheme.marked(mesh, payload(0), KEYS[0], 2e-4)
    budget = 2e-4 * PUBLISHED_MRMS / mrms_over_diagonal(mesh, trial)  # they grow together
    sets = {"0.008 % MRMS": marks(budget), "0.02 % RMS": marks(2e-4), "0.08 % RMS": marks(8e-4)}
    print(f"  cho_mean; 0.008 % MRMS is {100 * budget:.4f} % RMS vertex displacement")
    print(
        "    {:<16}{:>10}".format("attack", "published") + "".join(f"{name:>14}" for name in sets) + "  bar"
    )
    good = True
    for chain, published in PUBLISHED.items():
        rates = [errors(scheme, held, chain) for held in sets.values()]
        low, high = BARS.get(chain, (0.0, 1.0))
        holds = low <= rates[0] <= high
        good &= holds
        told = f"  {low:g} to {high:g}: {'yes' if holds else 'NO'}" if chain in BARS else ""
        print(
            f"    {chain:<16}{published:>10.2f}" + "".join(f"{rate:>14.3f}" for rate in rates) + told,
            flush=True,
        )
    return good


def rows(name: str, scheme: Rival, mesh: Mesh, bars: dict[str, tuple[float, float]]) -> bool:
    marked = [scheme.embed(mesh, payload(seed), key) for seed, key in enumerate(KEYS)]
    print(f"  {name}")
    good = True
    for chain, (low, high) in bars.items():
        rate = errors(scheme, marked, chain)
        good &= low <= rate <= high
        print(
            f"    {chain:<16}{rate:>10.3f}  {low:g} to {high:g}: {'yes' if low <= rate <= high else 'NO'}",
            flush=True,
        )
    return good


def verification(mesh: Mesh) -> bool:
    scheme, key = Mdaqim(), KEYS[0]
    marked = scheme.embed(mesh, payload(0), key)
    good = True
    for chain, least in (("none", 0.95), ("float32:1", 0.95), ("similarity:1", 0.95), ("noise:0.003", 0.0)):
        share = float(scheme.verify(attacked(marked, chain, 0), key)[1].mean())
        good &= share >= least
        print(f"    {chain:<16}{share:>10.3f} of the units verify, expected at least {least:g}", flush=True)
    bumped = attacked(marked, "bump:0.01", 0)
    units, holds = scheme.verify(bumped, key)
    moved = (Host(marked).points != Host(bumped).points).any(axis=1)[units].any(axis=1)
    inside, outside = float(holds[moved].mean()), float(holds[~moved].mean())
    print(f"    bump:0.01       {inside:>10.3f} of the units in it verify, {outside:.3f} of the others")
    return good


def main() -> int:
    if not DATA.is_dir():
        print(f"left out: {DATA} is not on this machine")
        return 0
    tasks: list[Callable[[Mesh], bool]] = [
        cho,
        lambda mesh: rows(
            "lsb", Lsb(), mesh, {"none": (0.0, 0.0), "float32:1": CHANCE, "similarity:1": CHANCE}
        ),
        lambda mesh: rows("mdaqim", Mdaqim(), mesh, {"none": (0.0, 0.0), "similarity:1": (0.0, 0.0)}),
        verification,
    ]
    good = True
    for name in sys.argv[1:] or MODELS:
        mesh = load(DATA / "models" / "test" / f"{name}.off.xz")
        print(f"{name}: {len(mesh.vertices)} points")
        for task in tasks:
            good &= task(mesh)
    print("within the bars" if good else "outside a bar")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
