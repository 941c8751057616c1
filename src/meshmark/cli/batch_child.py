"""A process for each thread of a cluster's worker, which does the models of a batch and may crash or hang.

A line of JSON with a model goes in, a line with its row comes out; the process stays for the thread's next model.
It is no `multiprocessing` one, which the workers of Dask may not start.
"""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from dataclasses import asdict
from pathlib import Path

from meshmark.batch.results import Row
from meshmark.batch.sources import Item
from meshmark.cli.batch_job import BatchCommand, done
from meshmark.workers.memory import limit_memory
from meshmark.workers.worker_pool import Lost

__all__ = ["end_child", "in_child"]

_HERE = threading.local()


def in_child(command: BatchCommand, seconds: float, memory_mb: int, item: Item) -> Row | Lost:
    """Return the row of a model, worked out within these limits by the process of this thread."""
    process = _process(memory_mb)
    asked = {"command": asdict(command), "item": {**asdict(item), "path": str(item.path)}}
    late = threading.Event()

    def end() -> None:
        late.set()
        process.kill()

    timer = threading.Timer(seconds, end)
    timer.start()
    try:
        print(json.dumps(asked), file=process.stdin, flush=True)
        line = process.stdout.readline() if process.stdout else ""
    except BrokenPipeError:
        line = ""
    finally:
        timer.cancel()
    if line.endswith("\n"):
        row: Row = json.loads(line)
        return row
    code = end_child()
    if late.is_set():
        return Lost(why="timeout", note=f"took longer than {seconds:g} s")
    return Lost(why="killed", note=f"its process ended with exit code {code}")


def _process(memory_mb: int) -> subprocess.Popen[str]:
    """Return the process of this thread, a new one where there is none with this limit of memory."""
    process: subprocess.Popen[str] | None = getattr(_HERE, "process", None)
    if process is not None and _HERE.memory_mb == memory_mb and process.poll() is None:
        return process
    end_child()
    process = subprocess.Popen(
        [sys.executable, "-m", "meshmark.cli.batch_child", str(memory_mb)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    _HERE.process, _HERE.memory_mb = process, memory_mb
    return process


def end_child() -> int:
    """End the process of this thread, if there is one, and return its exit code."""
    process: subprocess.Popen[str] | None = getattr(_HERE, "process", None)
    if process is None:
        return 0
    process.kill()
    with process:  # waits, and closes its pipes
        _HERE.process = None
    return process.returncode


def _work(memory_mb: int) -> None:
    """Answer the lines of standard input; ends with it, as when the worker of the cluster is gone."""
    limit_memory(memory_mb)
    for line in sys.stdin:
        asked = json.loads(line)
        command = BatchCommand(**{**asked["command"], "options": tuple(asked["command"]["options"])})
        item = Item(**{**asked["item"], "path": Path(asked["item"]["path"])})
        print(json.dumps(done(command, item), allow_nan=False), flush=True)


if __name__ == "__main__":
    _work(int(sys.argv[1]))
