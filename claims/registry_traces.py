"""Whose copy it is: damaged copies of the test models, and copies put together, against a registry of 10,000 ids.

python -m claims.registry_traces [--ids 10000] [--copies 3] [--least 2500] [--together] [--beyond] [--minutes M]

Of each model in ../shared/data/models/test a few copies are made (standard strength) and entered; ids that nobody
has are spread over all originals. One copy is damaged in each of several ways, then turned, scaled and moved (not
with --together). Two, three and five copies, as far as there are so many, are put together: average, median, least
and largest coordinates, and a mosaic of pieces; then given 0.1 % of noise, turned, and saved as another format.
Printed, by damage: suspects whose right recipients were named (of several: one, and all), whose original was among
the candidates, and that named a wrong one; processor time, with --beyond that of `extract` without a registry
taken off.

Exit 1 where anybody was named wrongly. For docs/decisions/0025-registry.md.
"""

from __future__ import annotations

import argparse
import secrets
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

import meshmark as mm
from claims.models import load, model_paths
from claims.security.collusion import GROUPS, suspects
from meshmark.attacks import ATTACKS, parse_chain
from meshmark.errors import CapacityError, MeshmarkError
from meshmark.mesh import FloatArray
from meshmark.registry.database_tables import copies
from meshmark.registry.entering import original_of_mesh
from meshmark.registry.recording import recorded
from meshmark.registry.registry import Registry
from meshmark.registry.tracing import trace

KEY = mm.Key(bytes(range(32)))
DAMAGES = {
    "none": (),
    "crop 10 % + noise .3 %": (("crop", 0.1), ("noise", 0.003)),
    "crop 30 % + simplification 50 %": (("crop", 0.3), ("simplification", 0.5)),
    "crop 50 %": (("crop", 0.5),),
    "noise 1 %": (("noise", 0.01),),
    "noise 2 %": (("noise", 0.02),),
    "8 bits + smoothing .1 x 30": (("quantisation", 8), ("smoothing", 30)),
}
AFTERWARDS = parse_chain("noise:0.001+similarity:1+file_glb:1")
"""What is done to copies once they are put together."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A suspect and the ids of the copies that it was made of."""

    damage: str
    suspect: mm.Mesh
    ids: tuple[int, ...]
    original: str


def marked(
    mesh: mm.Mesh, name: str, registry: Registry, layers: str, count: int
) -> list[tuple[int, mm.Mesh]]:
    """Enter copies of a model, and return them with their ids."""
    original = original_of_mesh(mesh, name, registry)
    made = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            path = Path(folder) / f"{number}.ply"
            with recorded(registry, original, KEY, path, recipient=f"{name} {number}") as entry:
                result = mm.embed_file(mesh, path, KEY, id=entry.id, layers=layers)
                entry.complete(result, path)
            made.append((entry.id, mm.read_mesh(path)))
    return made


def cases(made: list[tuple[int, mm.Mesh]], name: str, seed: int) -> Iterator[Case]:
    """Yield what is made of one copy of a model."""
    turned = ATTACKS["similarity"]
    for damage, steps in DAMAGES.items():
        rng = np.random.default_rng(seed)
        suspect = made[0][1]
        try:
            for attack, strength in steps:
                suspect = ATTACKS[attack](suspect, strength, rng)
            yield Case(damage=damage, suspect=turned(suspect, 1, rng), ids=(made[0][0],), original=name)
        except MeshmarkError as error:
            print(f"{name}, {damage}: {error}")


def together(made: list[tuple[int, mm.Mesh]], name: str, seed: int) -> Iterator[Case]:
    """Yield what is made of several copies of a model."""
    copies, faces = np.stack([mesh.vertices for _, mesh in made]), made[0][1].faces
    mosaics = (
        (group, "mosaic", mm.Mesh(pieces(copies[:group]), faces)) for group in GROUPS if group <= len(made)
    )
    for group, kind, mesh in chain(suspects(mm.Mesh(copies[0], faces), copies), mosaics):
        suspect = AFTERWARDS(mesh, np.random.default_rng(seed))
        ids = tuple(each for each, _ in made[:group])
        yield Case(damage=f"{kind} of {group}", suspect=suspect, ids=ids, original=name)


def pieces(copies: FloatArray) -> FloatArray:
    """Return vertices (n, 3) of which each slab across the longest side, as many as copies (k, n, 3), is of one."""
    axis = int(np.ptp(copies[0], axis=0).argmax())
    rank = np.argsort(np.argsort(copies[0][:, axis], kind="stable"), kind="stable")
    return copies[rank * len(copies) // len(rank), np.arange(len(rank))]


def fill(registry: Registry, ids: int) -> None:
    """Spread ids that nobody has over all originals."""
    with registry.database.writing() as connection:
        rows = [row for (row,) in connection.exec_driver_sql("SELECT row FROM originals")]
        have = connection.exec_driver_sql("SELECT count(*) FROM copies").scalar_one()
        connection.execute(
            copies.insert(),
            [
                {
                    "id": f"{secrets.randbits(64):016x}", "key": KEY.fingerprint, "state": "issued",
                    "original_row": rows[number % len(rows)], "recipient": "innocent",
                }
                for number in range(max(ids - have, 0))
            ],
        )  # fmt: skip


def time_of_extract(suspect: mm.Mesh) -> float:
    """Return the processor time of an extraction without a registry."""
    start = time.process_time()
    mm.extract(mm.Mesh(suspect.vertices.copy(), suspect.faces.copy()), KEY)
    return time.process_time() - start


def main() -> int:
    """Measure and print; exit 1 where anybody was named wrongly."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--ids", type=int, default=10_000)
    parser.add_argument("--copies", type=int, default=3)
    parser.add_argument("--least", type=int, default=2500, help="points of a model")
    parser.add_argument("--layers", choices=["ownership", "both"], default="ownership")
    parser.add_argument("--folder", default="models/test")
    parser.add_argument("--together", action="store_true", help="only copies that are put together")
    parser.add_argument("--models", type=int, default=10**9, help="so many at most, evenly chosen")
    parser.add_argument("--beyond", action="store_true", help="take off the time of `extract`")
    parser.add_argument("--minutes", type=float, default=float("inf"))
    arguments = parser.parse_args()
    end = time.monotonic() + 60.0 * arguments.minutes
    table: dict[str, list[tuple[float, ...]]] = defaultdict(list)
    wrongly = 0
    with tempfile.TemporaryDirectory() as folder, Registry.create(Path(folder) / "r.db")[0] as registry:
        found: list[Case] = []
        paths = list(model_paths(arguments.folder))
        for seed, path in enumerate(paths[:: -(-len(paths) // arguments.models)]):
            mesh = load(path)
            name = path.name.partition(".")[0]
            if len(mesh.vertices) < arguments.least or time.monotonic() > end:
                original_of_mesh(mesh, name, registry)
                continue
            try:
                made = marked(mesh, name, registry, arguments.layers, arguments.copies)
            except CapacityError as error:
                print(f"{name}: {error}")
                continue
            found += [] if arguments.together else cases(made, name, seed)
            found += together(made, name, seed)
        fill(registry, arguments.ids)
        for case in found:
            if time.monotonic() > end:
                break
            alone = time_of_extract(case.suspect) if arguments.beyond else 0.0
            suspect = mm.Mesh(case.suspect.vertices.copy(), case.suspect.faces.copy())
            start = time.process_time()
            traced = trace(suspect, KEY, registry)
            seconds = time.process_time() - start
            named = {match.id for match in traced.matches}
            wrong = named - set(case.ids)
            wrongly += len(wrong)
            right = len(named & set(case.ids))
            known = case.original in [each.name for each in traced.candidates]
            table[case.damage].append((right > 0, right == len(case.ids), known, len(wrong), seconds - alone))
            print(
                f"{case.original}, {case.damage}: named {right} of {len(case.ids)}, wrong {len(wrong)}, "
                f"{len(case.suspect.vertices)} points, {seconds:.1f} s, extract {alone:.1f} s",
                flush=True,
            )
    print(f"\n{'damage':34} suspects   one   all  candidate  wrong  seconds: mean, most")
    for damage, rows in table.items():
        one, whole, known, wrong, beyond = (np.array(column) for column in zip(*rows, strict=True))
        print(
            f"{damage:34} {len(rows):8} {one.mean():5.2f} {whole.mean():5.2f} {known.mean():10.2f} "
            f"{int(wrong.sum()):6} {beyond.mean():22.1f}, {beyond.max():.1f}"
        )
    print(f"named wrongly: {wrongly} of {sum(map(len, table.values()))} suspects, {arguments.ids:,} ids")
    return int(wrongly > 0)


if __name__ == "__main__":
    sys.exit(main())
