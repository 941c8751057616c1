"""The loop of a batch: models are given to workers as these become free, and rows kept as they come."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterable
from typing import Protocol

from meshmark.batch.results import Results, Row, error_kind
from meshmark.batch.sources import Item
from meshmark.errors import OutputError
from meshmark.workers.worker_pool import Lost

__all__ = ["Executor", "run"]

# What a full disk says: it would say the same of all models that follow.
_FULL = tuple(os.strerror(number) for number in (errno.ENOSPC, errno.EDQUOT))


class Executor(Protocol):
    """What does the work: `workers.worker_pool.WorkerPool`, or a cluster."""

    @property
    def free(self) -> int:
        """Return how many models can be given out now."""

    @property
    def busy(self) -> int:
        """Return how many are being worked on."""

    def submit(self, job: Item) -> None:
        """Give a model to a free worker."""

    def finished(self) -> list[tuple[Item, Row | Lost]]:
        """Wait until a model is done, and return those that are."""


def run(models: Iterable[Item], executor: Executor, results: Results, report: Callable[[Row], None]) -> None:
    """Do what has no row yet; at most as many models are held at a time as there are workers.

    Raises `OutputError` where the disk is full: what has no row then is done by the next run.
    """
    left = (item for item in models if item.name not in results.done)
    more = True
    while True:
        while more and executor.free:
            item = next(left, None)
            if item is None:
                more = False
            else:
                executor.submit(item)
        if not executor.busy:
            return
        for item, outcome in executor.finished():
            row = _lost(item, outcome) if isinstance(outcome, Lost) else outcome
            if error_kind(row) == "output" and str(row["error"]["message"]).endswith(_FULL):
                raise OutputError(f"{row['error']['message']}; --resume goes on when there is space again")
            results.add(row)
            report(row)


def _lost(item: Item, lost: Lost) -> Row:
    error = {"kind": lost.why, "message": f"{item.name}: {lost.note}", "file": str(item.path)}
    return {"model": item.name, "digest": None, "exit_code": 2, "input": str(item.path), "error": error}
