"""What a worker process of a benchmark does: one job at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from meshmark.errors import CapacityError, MeshmarkError
from meshmark.research.benchmark.run.job import Job, Look, Mark, Outcome, Probe
from meshmark.research.benchmark.run.judging import judge
from meshmark.research.benchmark.run.marked_model import look, mark
from meshmark.research.benchmark.run.probes import probe
from meshmark.workers.memory import forget_peak, peak_mb
from meshmark.workers.worker_pool import Lost

__all__ = ["Setup", "ended", "work"]


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What all jobs of a run share: the folders of models and of results, and the memory a worker may use.

    schemes: all that are measured.
    """

    data: Path
    out: Path
    worker_memory_mb: int
    schemes: tuple[str, ...] = ()


def work(setup: Setup, job: Job) -> Outcome:
    """Do one job; whatever goes wrong in it is an outcome."""
    forget_peak()
    outcome = _outcome(_function(setup, job), setup)
    if isinstance(job, Probe):  # its figures are those that its table knows, no others
        return outcome
    return Outcome(
        status=outcome.status, note=outcome.note, figures={**outcome.figures, "peak_mb": peak_mb()}
    )


def ended(result: Outcome | Lost) -> Outcome:
    """Return the outcome of a job, also of one that lost its worker."""
    return Outcome(status=result.why, note=result.note) if isinstance(result, Lost) else result


def _function(setup: Setup, job: Job) -> Callable[[], Outcome]:
    if isinstance(job, Look):
        return partial(look, setup.data, job)
    if isinstance(job, Mark):
        return partial(mark, setup.data, setup.out, job)
    if isinstance(job, Probe):
        return partial(probe, setup.data, job)
    return partial(judge, setup.data, setup.out, job, setup.schemes)


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
