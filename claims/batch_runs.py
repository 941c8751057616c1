"""What a batch costs and bears: `python -m claims.batch_runs`.

[--folder psb/train] [--least 500] [--most 3000] [--limit 24] [--kills 6] [--seed 0]
[--parts flat speed kills disk cluster]

Models are unpacked into a folder of their own and marked by `meshmark batch embed`, in processes as a user starts
them.

flat     processor time and memory of the process that gives out models, for 20 and for 1,000 files that are none
speed    two workers against one: time, and the share of it in which workers do not work; processor time of the
         process that gives out the models over that of the single commands
kills    the run is killed by SIGKILL at random moments, or one of its workers is, and gone on with by --resume
         until it is done; then every model has one row, and every copy is that of the run without kills
disk     the same on a file system that is full after some copies (needs the right to mount one)
cluster  the same models by a Dask scheduler with two worker processes, of which one is killed halfway

Figures of docs/decisions/0029-batch.md.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from claims.models import DATA, load, model_paths
from meshmark.coding.keys import Key
from meshmark.geometry.surface_of import surface_of
from meshmark.io import write_mesh

PARTS = ("flat", "speed", "kills", "disk", "cluster")
DRIVER = """
import sys, time
from meshmark.cli.main import main
from meshmark.workers.memory import peak_mb
if __name__ == "__main__":
    code = main(sys.argv[1:])
    print(code, time.process_time(), peak_mb(), file=sys.stderr)
"""
ALONE = """
import contextlib, io, sys, time
from meshmark.cli.main import main
for path in sys.argv[1:]:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        main(["embed", path, "alone.ply", "--key", "my.key", "--force", "--json"])
print(time.process_time())
"""
# Bars: how many times as fast two workers are, and what giving out the models may cost.
TIMES, SHARE = 1.75, 0.05
# A file system that holds about so much of the copies.
PART_OF_COPIES = 0.4


class Batch:
    """A folder with models/, a key, and runs beside each other."""

    def __init__(self, home: Path, options: argparse.Namespace) -> None:
        self.home, self.whole = home, home / "whole"
        (home / "models").mkdir()
        Key(bytes(range(32))).save(home / "my.key")
        self.count = 0
        for path in model_paths(options.folder):
            mesh = load(path)
            if self.count < options.limit and options.least <= len(surface_of(mesh).points) <= options.most:
                write_mesh(mesh, home / "models" / f"{path.relative_to(DATA).name.split('.')[0]}.ply")
                self.count += 1

    def started(self, out: str, *more: str, source: str = "models") -> subprocess.Popen[str]:
        """Start a run in a session of its own."""
        line = ["batch", "embed", source, out, "--key", "my.key", *more]
        return subprocess.Popen(
            [sys.executable, "-c", DRIVER, *line], cwd=self.home, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
        )  # fmt: skip

    def run(self, out: str, *more: str, source: str = "models") -> tuple[float, float, float]:
        """Return wall-clock seconds, and processor seconds and MB of the process that gives out models."""
        start = time.perf_counter()
        _, told = self.started(out, *more, source=source).communicate()
        seconds = time.perf_counter() - start
        _, processor, memory = map(float, told.splitlines()[-1].split())
        return seconds, processor, memory

    def rows(self, out: str | Path) -> list[dict[str, object]]:
        """Return the lines of the results of a run."""
        text = (self.home / out / "results.jsonl").read_text()
        return [json.loads(line) for line in text.splitlines()]

    def copies(self, out: str | Path) -> dict[str, bytes]:
        """Return the marked files of a run, by their names."""
        return {path.name: path.read_bytes() for path in (self.home / out).glob("*.ply")}

    def same(self, out: str | Path) -> bool:
        """Whether every model has one row, and every copy is that of the undisturbed run."""
        names = sorted(str(row["model"]) for row in self.rows(out))
        whole = sorted(str(row["model"]) for row in self.rows(self.whole))
        return names == whole and self.copies(out) == self.copies(self.whole)


def worked(rows: list[dict[str, object]]) -> float:
    """Return the seconds that the single commands say they took."""
    return sum(float(str(row.get("seconds", 0.0))) for row in rows)


def speed(batch: Batch) -> bool:
    one = batch.run("one", "--workers", "1")
    two = batch.run("two", "--workers", "2")
    line = [sys.executable, "-c", ALONE, *map(str, (batch.home / "models").iterdir())]
    work = float(subprocess.run(line, cwd=batch.home, capture_output=True, text=True, check=True).stdout)
    shares = [two[1] / work, one[1] / work]
    idle = [
        1.0 - worked(batch.rows(out)) / (workers * ran[0])
        for out, workers, ran in (("one", 1, one), ("two", 2, two))
    ]
    print(f"one worker {one[0]:.1f} s, two {two[0]:.1f} s: {one[0] / two[0]:.2f} times as fast")
    free = 2.0 * (1.0 - idle[1]) / (1.0 - idle[0])
    print(f"where each has a core of its own, by the time that they work: {free:.2f} times")
    print(
        f"workers not working: {idle[0]:.1%} of the time of one, {idle[1]:.1%} of that of two, start included"
    )
    print(
        f"giving out models: {shares[1]:.2%} of the work to one worker, {shares[0]:.2%} to two (processor time)",
        flush=True,
    )
    return one[0] / two[0] >= TIMES and max(shares) <= SHARE and batch.same("one") and batch.same("two")


def flat(batch: Batch) -> bool:
    """Read files that are no models, which takes no time: what is left is what giving them out costs."""
    found = {}
    for count in (20, 1000):
        folder = batch.home / f"{count} files"
        folder.mkdir()
        for number in range(count):
            (folder / f"{number}.ply").write_text(f"ply\n{number}\n")
        found[count] = batch.run(f"of {count}", "--workers", "2", source=folder.name)
    each = (found[1000][1] - found[20][1]) / 980
    print(f"giving out a model: {1e3 * each:.2f} ms of processor time, the start left out")
    print(f"memory: {found[20][2]:.0f} MB for 20, {found[1000][2]:.0f} MB for 1,000", flush=True)
    return found[1000][2] < 1.1 * found[20][2]


def kills(batch: Batch, count: int, rng: random.Random) -> bool:
    """Kill runs and workers at random moments, until each of `count` runs is done."""
    expected = batch.run("timed", "--workers", "2")[0]
    good = True
    for number in range(count):
        out, starts = f"killed {number}", 0
        while True:
            process = batch.started(out, "--workers", "2", *(["--resume"] if starts else []))
            starts += 1
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.communicate(timeout=rng.uniform(0.1, 0.8) * expected)
                break
            if number % 2:
                process.kill()
                process.communicate()
            else:
                for worker in descendants(process.pid)[-1:]:
                    os.kill(worker, signal.SIGKILL)
                process.communicate()
                break
        same = batch.same(out)
        print(
            f"run {number}: {'killed' if number % 2 else 'a worker killed'}, {starts} starts, same: {same}",
            flush=True,
        )
        good = good and same
    return good


def descendants(parent: int) -> list[int]:
    """Return the processes below one, those that were started last at the end."""
    found: dict[int, list[int]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            words = stat.read_text().rpartition(")")[2].split()
            found.setdefault(int(words[1]), []).append(int(stat.parent.name))
    below, todo = [], [parent]
    while todo:
        children = found.get(todo.pop(), [])
        below += children
        todo += children
    return sorted(below)


@contextlib.contextmanager
def small_disk(place: Path, size: int) -> Iterator[bool]:
    """Mount a file system of so many bytes, if that is allowed."""
    place.mkdir()
    line = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(place)]
    mounted = subprocess.run(line, capture_output=True, check=False).returncode == 0
    try:
        yield mounted
    finally:
        if mounted:
            subprocess.run(["umount", str(place)], check=False)


def disk(batch: Batch) -> bool:
    size = int(PART_OF_COPIES * sum(map(len, batch.copies(batch.whole).values())))
    with small_disk(batch.home / "full", size) as mounted:
        if not mounted:
            print("disk: not measured, no file system can be mounted here")
            return True
        process = batch.started("full", "--workers", "2")
        _, told = process.communicate()
        there = len(batch.rows("full"))
        subprocess.run(["mount", "-o", "remount,size=1g", str(batch.home / "full")], check=True)
        batch.run("full", "--workers", "2", "--resume")
        same = batch.same("full")
        print(
            f"disk: {told.splitlines()[0]!r} after {there} of {batch.count} models; gone on with, same: {same}"
        )
    return same


def cluster(batch: Batch) -> bool:
    """Mark by a scheduler and two workers in processes of their own, of which one is killed halfway."""
    file = batch.home / "scheduler.json"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": batch.home}
    running = [subprocess.Popen([*dask, "--no-dashboard", "--scheduler-file", str(file)], **quiet)]
    try:
        while not file.exists():
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        line = [
            sys.executable,
            "-m",
            "distributed.cli.dask_worker",
            address,
            "--nthreads",
            "1",
            "--no-dashboard",
            "--no-nanny",
        ]
        running += [subprocess.Popen(line, **quiet) for _ in range(2)]
        process = batch.started("by cluster", "--scheduler", address, "--json-lines")
        for _ in range(batch.count // 2):
            assert process.stdout
            process.stdout.readline()
        running[-1].kill()
        process.communicate()
        same = batch.same("by cluster")
        print(f"cluster: one of two workers killed halfway, same: {same}", flush=True)
        return same
    finally:
        for each in reversed(running):
            each.kill()
            each.wait()


def main() -> int:
    """Measure and print; exit 1 where a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--folder", default="psb/train")
    parser.add_argument("--least", type=int, default=500)
    parser.add_argument("--most", type=int, default=3000)
    parser.add_argument("--limit", type=int, default=24)
    parser.add_argument("--kills", type=int, default=6)
    parser.add_argument("--parts", nargs="+", default=list(PARTS), choices=PARTS)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        batch = Batch(Path(folder), options)
        batch.run("whole", "--workers", "1")
        rows = batch.rows("whole")
        print(f"{batch.count} models, {sum('error' not in row for row in rows)} marked", flush=True)
        done = {
            "flat": lambda: flat(batch),
            "speed": lambda: speed(batch),
            "kills": lambda: kills(batch, options.kills, random.Random(options.seed)),
            "disk": lambda: disk(batch),
            "cluster": lambda: cluster(batch),
        }
        outcomes = [done[part]() for part in options.parts]
        return int(not all(outcomes))


if __name__ == "__main__":
    sys.exit(main())
