"""Innocent recipients: how often issued ids that are not in a suspect reach a bound, beside the bound.

python -m claims.registry_innocent [--lists 200] [--ids 1000]

Readings are taken of marked copies of the hare (whole, cropped, with noise, averaged) and of the unmarked hare,
blind and by a certificate. Each is compared with lists of random ids of which none is in it, as `trace` compares
issued ids. A trial is one reading and one list; its bound is the least of the list, ids counted, before readings
are counted. Printed: the share of trials below 10^-k, which is at most 10^-k where the bound holds, and how many
would accuse somebody at 10^-6.

Exit 1 where a share is significantly above its bound, or anybody is accused. For docs/decisions/0025-registry.md.
"""

from __future__ import annotations

import argparse
import secrets
import sys
from collections.abc import Iterator
from io import BytesIO

import numpy as np

import meshmark as mm
from meshmark.attacks import ATTACKS
from meshmark.coding.codec import Codec
from meshmark.data import hare_ply
from meshmark.geometry.surface_of import surface_of
from meshmark.io import read_mesh_from
from meshmark.mesh import FloatArray
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.strategies import STRATEGIES

KEY = mm.Key(bytes(32))
LEVELS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0)
COPIES = 3


def suspects() -> tuple[list[mm.Mesh], mm.Certificate]:
    """Return suspects made of marked copies of the hare, and the certificate of one."""
    hare = read_mesh_from(BytesIO(hare_ply()), "ply")
    marked = [mm.embed(hare, KEY, id=number, layers="ownership") for number in range(COPIES)]
    copies = [each.mesh for each in marked]
    rng = np.random.default_rng(1)
    mean = mm.Mesh(np.mean([mesh.vertices for mesh in copies], axis=0), hare.faces)
    found = [
        hare,
        *copies,
        mean,
        ATTACKS["crop"](copies[0], 0.3, rng),
        ATTACKS["noise"](copies[1], 0.01, rng),
    ]
    return found, marked[0].certificate


def readings(suspect: mm.Mesh, certificate: mm.Certificate) -> Iterator[FloatArray]:
    """Yield what the readings of a suspect say of the code bits."""
    search = Search(surface=surface_of(suspect), key=KEY, effort="plain", reference=certificate)
    for strategy in STRATEGIES:
        if strategy.applies(search):
            for reading in strategy.readings(search):
                yield reading.observed()


def main() -> int:
    """Measure and print; exit 1 where the bound does not hold."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--lists", type=int, default=200)
    parser.add_argument("--ids", type=int, default=1000)
    arguments = parser.parse_args()
    found, certificate = suspects()
    observed = [each for suspect in found for each in readings(suspect, certificate)]
    codec = Codec(KEY)
    least = []
    for _ in range(arguments.lists):
        words = codec.words([secrets.randbits(64) for _ in range(arguments.ids)])
        least += [float(codec.chances(each, words).min()) for each in observed]
    bounds = np.array(least)
    print(f"{len(observed)} readings, {len(bounds):,} trials of {arguments.ids:,} ids")
    missed = False
    for level in LEVELS:
        count, most = int((bounds <= -level).sum()), len(bounds) * 10.0**-level
        missed |= count > most + 4.0 * np.sqrt(most) + 1.0
        print(f"below 10^-{level:g}: {count:6} trials, {most:10.2f} at most")
    accused = int((bounds <= -6.0).sum())
    print(f"accused at 10^-6: {accused}")
    return int(missed or accused > 0)


if __name__ == "__main__":
    sys.exit(main())
