"""How fast and how safe a registry is: 100,000 copies, eight writers at once, and writers that are killed.

python -m claims.registry_scale [--rows 100000] [--kills 50] [--sqlite-only]

On SQLite, and on a PostgreSQL server of its own where Debian's programs are installed:

- seconds of looking up a copy by its id (at most 0.05) and of finding the likely originals of a suspect by its
  shape (at most 2), of as many originals as copies, the largest of a few;
- rows lost or double after eight processes wrote 500 copies each (none);
- acknowledged rows lost after so many rounds in which two writers were killed at random moments (none).

Exit 1 where one is missed. For docs/decisions/0025-registry.md.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.registry.database_tables import copies, originals
from meshmark.registry.likely_originals import candidates
from meshmark.registry.registry import Registry
from meshmark.registry.shape_descriptor import described
from tests.registry.postgres import server, why_not
from tests.registry.records_samples import KEY, TIME
from tests.registry.test_registry import WRITER
from tests.shapes import pebble

BY_ID, BY_SHAPE = 0.05, 2.0
WRITERS, EACH = 8, 500
BLOCK = 10_000


def fill(registry: Registry, rows: int) -> None:
    """Enter as many originals as copies; their shapes are that of a pebble with its words shuffled."""
    shape, rng = described(surface_of(Mesh(*pebble(48)))), np.random.default_rng(1)
    words = np.frombuffer(shape[5:], np.uint8)
    for start in range(0, rows, BLOCK):
        numbers = range(start, min(start + BLOCK, rows))
        with registry.database.writing() as connection:
            connection.execute(
                originals.insert(),
                [
                    {
                        "row": number + 1, "digest": f"{number:064x}", "name": f"{number}.ply", "points": 1,
                        "registered_at": TIME, "descriptor": shape[:5] + rng.permutation(words).tobytes(),
                    }
                    for number in numbers
                ],
            )  # fmt: skip
            connection.execute(
                copies.insert(),
                [
                    {
                        "id": f"{number:016x}", "key": KEY, "original_row": number + 1, "recipient": f"{number}",
                        "state": "issued", "issued_at": TIME,
                    }
                    for number in numbers
                ],
            )  # fmt: skip


def longest(call: Callable[[], object], repeats: int) -> float:
    """Return the most seconds that a call took."""
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    return max(seconds)


def lookups(place: str, rows: int) -> tuple[float, float]:
    """Return the seconds of a lookup by id and by shape in an open registry, the longest of several."""
    made, _ = Registry.create(place)
    with made:
        fill(made, rows)
    suspect = surface_of(Mesh(*pebble(60)))
    rng = random.Random(1)

    with Registry.open(place) as registry:

        def by_id() -> None:
            (found,) = registry.copies_with_id(number := rng.randrange(rows), KEY)
            assert found.recipient == f"{number}"

        def by_shape() -> None:
            assert len(candidates(registry, suspect, KEY)) == min(rows, 10)

        by_id()
        return longest(by_id, 200), longest(by_shape, 5)


def writing(place: str, writers: int, each: int) -> subprocess.Popen[str]:
    """Start processes that write copies, and print the id of each when it is acknowledged."""
    command = [sys.executable, "-c", WRITER, place, str(writers), str(each)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)


def together(place: str) -> int:
    """Return how many rows were lost or double after eight processes wrote at once."""
    told = [line.split()[1] for line in writing(place, WRITERS, EACH).communicate()[0].splitlines()]
    with Registry.open(place) as registry:
        kept = [str(copy.id) for copy in registry.copies() if copy.state == "issued"]
    wrong = set(told) ^ set(kept)
    return len(wrong) + len(kept) - len(set(kept)) + abs(WRITERS * EACH - len(kept))


def killed(place: str, rounds: int) -> tuple[int, int]:
    """Return acknowledged rows, and how many of them were lost, after writers were killed at random moments."""
    Registry.create(place)[0].database.close()
    told: list[str] = []
    rng = random.Random(2)
    for _ in range(rounds):
        process = writing(place, 2, 1_000_000)
        assert process.stdout is not None
        lines = [process.stdout.readline()]  # begun
        time.sleep(rng.uniform(0.0, 0.2))
        os.killpg(process.pid, signal.SIGKILL)
        lines += process.stdout.read().splitlines(keepends=True)
        process.wait()
        told += [line.split()[1] for line in lines if line.endswith("\n")]
    with Registry.open(place) as registry:
        kept = {str(copy.id) for copy in registry.copies() if copy.state == "issued"}
    return len(told), len(set(told) - kept)


@contextmanager
def places(sqlite_only: bool) -> Iterator[dict[str, Callable[[str], str]]]:
    """Yield, by the kind of database, what returns the place of a new registry of a name."""
    with tempfile.TemporaryDirectory() as folder:
        found = {"SQLite": lambda name: str(Path(folder) / f"{name}.db")}
        if sqlite_only or (reason := why_not()):
            if not sqlite_only:
                print(f"without PostgreSQL: {reason}")
            yield found
            return
        import psycopg

        with server() as address:

            def database(name: str) -> str:
                with psycopg.connect(address, autocommit=True) as connection:
                    connection.execute(f"CREATE DATABASE {name}")
                return address.replace("/postgres?", f"/{name}?")

            yield {**found, "PostgreSQL": database}


def main() -> int:
    """Measure and print; exit 1 where a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rows", type=int, default=100_000)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--sqlite-only", action="store_true")
    arguments = parser.parse_args()
    missed = False
    with places(arguments.sqlite_only) as found:
        for kind, place in found.items():
            by_id, by_shape = lookups(place("lookups"), arguments.rows)
            wrong = together(place("writers"))
            told, lost = killed(place("kills"), arguments.kills)
            print(
                f"{kind}, {arguments.rows:,} copies: by id {1e3 * by_id:.1f} ms (at most {1e3 * BY_ID:.0f}), by "
                f"shape {by_shape:.2f} s (at most {BY_SHAPE:g}); {WRITERS} writers of {EACH}: {wrong} rows lost or "
                f"double; {arguments.kills} kills: {lost} of {told:,} acknowledged rows lost",
                flush=True,
            )
            missed |= by_id > BY_ID or by_shape > BY_SHAPE or wrong > 0 or lost > 0
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
