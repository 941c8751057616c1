"""What a worker process of a benchmark does: one job at a time, under limits, and it ends when its parent does."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from threadpoolctl import threadpool_limits

from meshmark.errors import CapacityError, MeshmarkError
from meshmark.research.benchmark.run.job import Job, Look, Mark, Outcome, Probe
from meshmark.research.benchmark.run.judging import judge
from meshmark.research.benchmark.run.marked_model import look, mark
from meshmark.research.benchmark.run.memory import forget_peak, limit_memory, peak_mb
from meshmark.research.benchmark.run.probes import probe

__all__ = ["Setup", "begin", "work"]


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What all jobs of a run share: the folders of models and of results, and the memory a worker may use."""

    data: Path
    out: Path
    worker_memory_mb: int


def begin(setup: Setup) -> None:
    """Prepare this process: one thread for linear algebra, a limit on memory, an end with the parent."""
    threadpool_limits(1)
    limit_memory(setup.worker_memory_mb)
    _end_with_parent()


def work(setup: Setup, job: Job) -> Outcome:
    """Do one job; whatever goes wrong in it is an outcome."""
    forget_peak()
    outcome = _outcome(_function(setup, job), setup)
    if isinstance(job, Probe):  # its figures are those that its table knows, no others
        return outcome
    return Outcome(
        status=outcome.status, note=outcome.note, figures={**outcome.figures, "peak_mb": peak_mb()}
    )


def _function(setup: Setup, job: Job) -> Callable[[], Outcome]:
    if isinstance(job, Look):
        return partial(look, setup.data, job)
    if isinstance(job, Mark):
        return partial(mark, setup.data, setup.out, job)
    if isinstance(job, Probe):
        return partial(probe, setup.data, job)
    return partial(judge, setup.data, setup.out, job)


def _outcome(function: Callable[[], Outcome], setup: Setup) -> Outcome:
    try:
        return function()
    except CapacityError as error:
        return Outcome(status="refused", note=str(error))
    except MeshmarkError as error:
        return Outcome(status="failed", note=str(error))
    except MemoryError:
        return Outcome(status="failed", note=f"needed more than {setup.worker_memory_mb} MiB of memory")
    except Exception as error:  # a scheme from outside may raise anything; its case is lost, not the run
        return Outcome(status="failed", note=" ".join(f"{type(error).__name__}: {error}".split()))


def _end_with_parent() -> None:
    """End this process when the one that started the run ends, however that happens."""
    from multiprocessing import connection, parent_process

    parent = parent_process()
    if parent is None:
        return

    def watch() -> None:
        connection.wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    if sys.platform == "linux":  # the thread cannot run while foreign code holds the interpreter
        import ctypes

        set_death_signal = 1
        ctypes.CDLL(None).prctl(set_death_signal, signal.SIGKILL)
