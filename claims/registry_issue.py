"""`registry issue` killed at random moments, and gone on with: no copy lost, none twice, no half file.

python -m claims.registry_issue [--kills 50] [--workers 2]

Copies of a small model are made for twice as many recipients as there are kills; the command and its workers are
killed up to three seconds after they hold their first new id, and it is run again with --resume. In the end every
recipient must have one row, issued, and one file that carries its id, with a certificate beside it; every id that
was held before a kill must be the one of its recipient still; nothing may be left under a temporary name.

Exit 1 where that is not so. For docs/decisions/0025-registry.md.
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
from pathlib import Path

import meshmark as mm
from meshmark.io.file_digest import digest_of_file
from meshmark.registry.registry import Registry
from tests.shapes import pebble

KEY = mm.Key(bytes(range(32)))
LONGEST = 3.0


def held(folder: Path) -> dict[str, int]:
    """Return the ids that are held, by recipient."""
    with Registry.open(folder / "r.db") as registry:
        return {str(copy.recipient): copy.id for copy in registry.copies()}


def faults(folder: Path, recipients: int) -> list[str]:
    """Return what is not as it should be in the end."""
    with Registry.open(folder / "r.db") as registry:
        rows = registry.copies()
    found = [] if len({row.recipient for row in rows}) == len(rows) == recipients else ["rows"]
    names = set()
    for row in rows:
        path = Path(str(row.path))
        names |= {path.name, f"{path.name}.cert"}
        if row.state != "issued" or digest_of_file(path) != row.marked_digest:
            found.append(f"{path.name}: {row.state}")
        elif mm.extract(mm.read_mesh(path), KEY, search="plain").id != row.id:
            found.append(f"{path.name}: not its id")
        mm.Certificate.load(f"{path}.cert")
    return found + sorted({path.name for path in (folder / "out").iterdir()} ^ names)


def main() -> int:
    """Kill, go on, and look; exit 1 where anything is wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    recipients = 2 * arguments.kills
    rng, changed = random.Random(1), 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        mm.write_mesh(mm.Mesh(*pebble(40)), folder / "in.ply")
        KEY.save(folder / "my.key")
        (folder / "people.csv").write_text("recipient\n" + "".join(f"r{i}\n" for i in range(recipients)))
        Registry.create(folder / "r.db")[0].database.close()
        line = [
            sys.executable,
            "-m",
            "meshmark",
            "registry",
            "issue",
            "in.ply",
            "--to",
            "people.csv",
            "--out",
            "out",
        ]
        line += ["--key", "my.key", "--registry", "r.db", "--layers", "ownership", "--resume"]
        line += ["--workers", str(arguments.workers)]
        before: dict[str, int] = {}
        for _ in range(arguments.kills):
            quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            process = subprocess.Popen(line, cwd=folder, start_new_session=True, **quiet)
            while process.poll() is None and len(held(folder)) == len(before):
                time.sleep(0.05)
            time.sleep(rng.uniform(0.0, LONGEST))
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            now = held(folder)
            changed += sum(now.get(each) != number for each, number in before.items())
            before = now
        ended = subprocess.run(line, cwd=folder, check=False, capture_output=True, text=True)
        wrong = faults(folder, recipients)
        changed += sum(held(folder)[each] != number for each, number in before.items())
    print(ended.stdout or ended.stderr, end="")
    print(
        f"{arguments.kills} kills, {len(before)} of {recipients} ids held by then, {changed} changed; "
        f"faults in the end: {', '.join(wrong) or 'none'}"
    )
    return int(bool(wrong) or changed > 0 or ended.returncode != 0)


if __name__ == "__main__":
    sys.exit(main())
