"""Worker processes, each in a pool of its own: a job that crashes or hangs takes nobody with it."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_all_start_methods, get_context
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from meshmark.errors import InputError, OutputError
from meshmark.workers.preparation import prepare

if TYPE_CHECKING:
    from pebble import ProcessPool

__all__ = ["Lost", "WorkerPool"]

_Job = TypeVar("_Job")
_Result = TypeVar("_Result")

# A worker can also be ended from outside, so a job is lost only when it loses its worker this often.
_TRIES = 3
# Seconds between looks at pools that say nothing.
_PATIENCE = 1.0
# Seconds until a process that was ended is gone, and another one is started in its place.
_PAUSE = 0.5


@dataclass(frozen=True, kw_only=True)
class Lost:
    """A job that ended without a result. why: "timeout" or "killed"; note: how, in words."""

    why: str
    note: str


class WorkerPool(Generic[_Job, _Result]):
    """A fixed number of workers, as a context manager.

    `submit` gives a job to a free one, `finished` waits for results.
    """

    def __init__(
        self,
        workers: int,
        function: Callable[[_Job], _Result],
        *,
        time_limit: float,
        memory_mb: int,
        preload: str,
    ) -> None:
        """Make the pool; each worker starts with its first job.

        function: what a worker does with a job, of a module; time_limit: of a job, seconds; memory_mb: of a worker,
        MiB; preload: the module that workers need. Raises `InputError` where pebble is missing.
        """
        try:
            import pebble  # noqa: F401
        except ImportError:
            raise InputError("worker processes need pebble: pip install meshmark[batch]") from None
        self.function, self.time_limit, self.memory_mb = function, time_limit, memory_mb
        # Children come from a process with one thread, which has imported what they need.
        method = "forkserver" if "forkserver" in get_all_start_methods() else "spawn"
        self._context: Any = get_context(method)
        if method == "forkserver":
            self._context.set_forkserver_preload([preload])
        self._free: list[ProcessPool | None] = [None] * workers
        self._busy: dict[Future[_Result], tuple[ProcessPool, _Job, int]] = {}

    def __enter__(self) -> WorkerPool[_Job, _Result]:
        return self

    def __exit__(self, *_: object) -> None:
        pools = [*(pool for pool in self._free if pool), *(pool for pool, *_ in self._busy.values())]
        _stop(pools)

    @property
    def free(self) -> int:
        """Return how many workers have no job."""
        return len(self._free)

    @property
    def busy(self) -> int:
        """Return how many workers have a job."""
        return len(self._busy)

    def submit(self, job: _Job, attempt: int = 1) -> None:
        """Give a job to a free worker; raises `OutputError` where no process can be started."""
        pool = self._free.pop()
        if pool is None or not pool.active:  # an idle worker was ended from outside
            pool = self._renewed(pool)
        for _ in range(_TRIES):
            try:
                future = pool.schedule(self.function, args=[job], timeout=self.time_limit)
            except BrokenProcessPool:  # the process that starts workers was ended from outside
                time.sleep(_PAUSE)
                pool = self._renewed(pool)
            else:
                self._busy[future] = pool, job, attempt
                return
        raise OutputError(f"no worker process can be started, tried {_TRIES} times")

    def finished(self) -> list[tuple[_Job, _Result | Lost]]:
        """Wait until a job ends and return those that have; one that lost its worker is tried again first."""
        results: list[tuple[_Job, _Result | Lost]] = []
        for future in self._ended():
            pool, job, attempt = self._busy.pop(future)
            outcome = self._outcome(future, pool)
            if isinstance(outcome, Lost) and outcome.why == "killed" and attempt < _TRIES:
                self.submit(job, attempt + 1)
            else:
                results.append((job, outcome))
        return results

    def _ended(self) -> list[Future[_Result]]:
        """Wait until a job has ended, or has lost its pool before the pool knew of it."""
        while True:
            done, others = wait(self._busy, timeout=_PATIENCE, return_when=FIRST_COMPLETED)
            ended = [*done, *(future for future in others if not self._busy[future][0].active)]
            if ended:
                return ended

    def _outcome(self, future: Future[_Result], pool: ProcessPool) -> _Result | Lost:
        from pebble import ProcessExpired

        if not future.done():
            wait((future,), timeout=_PATIENCE)  # a pool that has lost its worker may be about to say how
        if not future.done():
            outcome = Lost(why="killed", note="the worker ended before it could begin")
        else:
            try:
                result = future.result()
            except TimeoutError:
                outcome = Lost(why="timeout", note=f"took longer than {self.time_limit:g} s")
            except ProcessExpired as error:
                outcome = Lost(why="killed", note=f"the worker {_how(error.exitcode)}")
            except BrokenProcessPool:
                outcome = Lost(why="killed", note="the worker ended before it could begin")
            else:
                self._free.append(pool)
                return result
        self._free.append(self._renewed(pool))
        return outcome

    def _renewed(self, pool: ProcessPool | None) -> ProcessPool:
        """Return a new pool of one worker. A lock that a lost worker held stays locked in its old pool."""
        from pebble import ProcessPool

        if pool is not None:
            _stop([pool])
        return ProcessPool(max_workers=1, initializer=partial(prepare, self.memory_mb), context=self._context)


def _stop(pools: list[ProcessPool]) -> None:
    for pool in pools:
        pool.stop()  # type: ignore[no-untyped-call]
    for pool in pools:
        pool.join()


def _how(code: int) -> str:
    """Say how a process ended, from its exit code."""
    if code < 0:
        return f"was ended by {signal.Signals(-code).name}"
    return f"ended with exit code {code}"
