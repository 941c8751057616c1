"""Put hostile and odd files through `embed` and `authenticate`: each must end in an answer or one sentence.

Run: python -m claims.hostile [FOLDER ...] [--count 300] [--seed 1] [--store hostile.jsonl] [--again]
Without folders: `count` model files drawn from ../shared/data/hostile, and all of ../shared/data/field.
Each command is a process of its own with limits on processor time and memory. What is authenticated is the marked
file, or the file itself where it cannot be marked. Interrupted? Run it again: what is in the store is not repeated;
--again repeats what failed.

Figures of docs/decisions/0016-odd-files.md.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import NoReturn

from meshmark.cli.main import run as program
from meshmark.coding.keys import Key
from meshmark.io.formats import format_of_name

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
_MEMORY = 2 << 30
# Processor time, and the time on the clock after which a process is taken to hang, as many times that.
_SECONDS, _PATIENCE = 60, 5
_REFUSALS, _ANSWERS = (2, 4), (0, 1, 3)
_COMMANDS = ("embed", "authenticate")
# What the commands import when they run.
_SLOW = (
    "meshmark.marking.marked_file",
    "meshmark.io.gltf.parse",
    "meshmark.io.threemf.parse",
    "meshmark.metrics.shape",
)


@dataclass(frozen=True, kw_only=True)
class Ran:
    """One command on one file. fault: what is wrong with it, empty where nothing is."""

    file: str
    command: str
    code: int
    seconds: float
    said: str
    fault: str


def fault_of(code: int | None, out: str, err: str) -> str:
    """Return what is wrong with how a command ended, or nothing; code: None for one that was stopped."""
    lines = err.splitlines()
    if code is None:
        return "hang"
    if code == -signal.SIGXCPU:
        return "too slow"
    if code < 0:
        return f"crash by signal {-code}"
    if "Traceback" in out + err:
        return "traceback"
    if "bug in meshmark" in err:
        return "bug"
    if code not in (*_REFUSALS, *_ANSWERS):
        return f"exit code {code}"
    if any(not line.startswith("meshmark: ") for line in lines):
        return "stray words"
    if code in _REFUSALS and len(lines) != 1:
        return f"{len(lines)} sentences"
    return ""


def run(arguments: list[str], cwd: Path) -> tuple[int | None, str, str, float]:
    """Run one command of meshmark within the limits; return exit code, what it printed, and seconds on the clock.

    The process is forked from this one, which has the slow imports behind it.
    """
    start = time.monotonic()
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = os.fork()
        if child == 0:
            _become(arguments, cwd, (out.fileno(), err.fileno()))
        code = _awaited(child, start + _SECONDS * _PATIENCE)
        texts = []
        for stream in (out, err):
            stream.seek(0)
            texts.append(stream.read().decode(errors="replace"))
    return code, texts[0], texts[1], time.monotonic() - start


def _become(arguments: list[str], cwd: Path, streams: tuple[int, int]) -> NoReturn:
    code = 1
    try:
        for number, stream in enumerate(streams, 1):
            os.dup2(stream, number)
        sys.stdout, sys.stderr = (os.fdopen(number, "w", closefd=False) for number in (1, 2))
        os.chdir(cwd)
        resource.setrlimit(resource.RLIMIT_CPU, (_SECONDS, _SECONDS + 5))
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        sys.argv = ["meshmark", *arguments]
        program()
    except SystemExit as end:
        code = int(end.code or 0)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _awaited(child: int, deadline: float) -> int | None:
    """Return the exit code of a child, negative for a signal; None where it had to be stopped."""
    while time.monotonic() < deadline:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def judged(path: Path, name: str) -> Iterator[Ran]:
    """Run both commands on a file."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        key, marked = home / "owner.key", home / "marked" / path.name
        Key(bytes(range(32))).save(key)
        marked.parent.mkdir()
        for command in _COMMANDS:
            if command == "embed":
                arguments = ["embed", str(path), str(marked), "--key", str(key)]
            else:
                arguments = ["authenticate", str(marked if marked.exists() else path), "--key", str(key)]
            code, out, err, seconds = run(arguments, home)
            fault = fault_of(code, out, err)
            if not fault and command == "embed" and marked.exists() != (code == 0):
                fault = "output without success" if code else "success without output"
            said = (err.strip() or out.strip()).splitlines()
            yield Ran(
                file=name,
                command=command,
                code=-999 if code is None else code,
                seconds=round(seconds, 1),
                said=said[-1][:400] if said else "",
                fault=fault,
            )


def chosen(folders: list[Path], count: int, seed: int) -> dict[str, Path]:
    """Return the files to try by the names they have in the store."""
    if folders:
        return {str(path): path for folder in folders for path in sorted(folder.rglob("*")) if path.is_file()}
    hostile = [path for path in sorted((DATA / "hostile").rglob("*")) if path.is_file()]
    models = [path for path in hostile if format_of_name(path) is not None]
    drawn = sorted(random.Random(seed).sample(models, min(count, len(models))))
    field = [path for path in sorted((DATA / "field").rglob("*")) if path.is_file()]
    return {str(path.relative_to(DATA)): path for path in [*drawn, *field]}


def stored(store: Path, again: bool) -> dict[tuple[str, str], Ran]:
    """Return what the store has; again: without what failed."""
    lines = store.read_text().splitlines() if store.exists() else []
    found = [Ran(**json.loads(line)) for line in lines]
    return {(row.file, row.command): row for row in found if not (again and row.fault)}


def table(rows: list[Ran]) -> str:
    """Return counts by extension and command: answered, refused, faulty, and the slowest."""
    counts: Counter[tuple[str, str, str]] = Counter()
    slowest: dict[tuple[str, str], float] = {}
    for row in rows:
        kind = (Path(row.file).suffix.lower(), row.command)
        outcome = "faulty" if row.fault else "refused" if row.code in _REFUSALS else f"exit {row.code}"
        counts[(*kind, outcome)] += 1
        slowest[kind] = max(slowest.get(kind, 0.0), row.seconds)
    columns = ("exit 0", "exit 1", "exit 3", "refused", "faulty")
    lines = ["".join([f"{'kind':9}{'command':14}", *(f"{column:>9}" for column in columns), "  slowest s"])]
    for suffix, command in sorted(slowest):
        cells = (f"{counts[suffix, command, column]:9}" for column in columns)
        lines.append("".join([f"{suffix:9}{command:14}", *cells, f"{slowest[suffix, command]:11.1f}"]))
    return "\n".join(lines)


def main() -> int:
    """Print a table and every fault; return 1 if there is any."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--count", type=int, default=300, help="how many hostile files are drawn")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--store", type=Path, default=Path("hostile.jsonl"), help="where results are kept")
    parser.add_argument("--again", action="store_true", help="repeat what failed")
    options = parser.parse_args()
    files = chosen(options.folders, options.count, options.seed)
    done = stored(options.store, options.again)
    for module in _SLOW:
        import_module(module)
    with options.store.open("a") as store:
        for name, path in files.items():
            if all((name, command) in done for command in _COMMANDS):
                continue
            for row in judged(path, name):
                done[row.file, row.command] = row
                store.write(json.dumps(asdict(row)) + "\n")
                store.flush()
                if row.fault:
                    print(f"{row.fault}: {row.command} {row.file}: {row.said}", flush=True)
    rows = [row for (name, _), row in done.items() if name in files]
    print(table(rows))
    faulty = [row for row in rows if row.fault]
    for row in faulty:
        print(f"{row.fault}: {row.command} {row.file}: {row.said}")
    print(f"{len(files)} files, {len(rows)} commands, {len(faulty)} with a fault")
    return int(bool(faulty))


if __name__ == "__main__":
    sys.exit(main())
