"""A model of a batch in a process of its own, for workers of a cluster: it may crash or hang without harm."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

from meshmark.batch.results import Row
from meshmark.batch.sources import Item
from meshmark.cli.batch_job import BatchCommand, done
from meshmark.workers.memory import limit_memory
from meshmark.workers.worker_pool import Lost

__all__ = ["in_child"]


def in_child(command: BatchCommand, seconds: float, memory_mb: int, item: Item) -> Row | Lost:
    """Return the row of a model, worked out in a new process within these limits."""
    asked = {
        "command": asdict(command),
        "item": {**asdict(item), "path": str(item.path)},
        "memory_mb": memory_mb,
    }
    line = [sys.executable, "-m", "meshmark.cli.batch_child"]
    try:
        ran = subprocess.run(line, input=json.dumps(asked), capture_output=True, text=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        return Lost(why="timeout", note=f"took longer than {seconds:g} s")
    if ran.returncode != 0:
        return Lost(why="killed", note=f"its process ended with exit code {ran.returncode}")
    row: Row = json.loads(ran.stdout)
    return row


def _work() -> None:
    asked = json.load(sys.stdin)
    limit_memory(asked["memory_mb"])
    command = BatchCommand(**{**asked["command"], "options": tuple(asked["command"]["options"])})
    item = Item(**{**asked["item"], "path": Path(asked["item"]["path"])})
    print(json.dumps(done(command, item), allow_nan=False))


if __name__ == "__main__":
    _work()
