"""A Dask cluster as the executor of a batch: few models are handed out at a time, lost ones tried again."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from meshmark.batch.results import Row
from meshmark.batch.sources import Item
from meshmark.errors import InputError, OutputError
from meshmark.workers.worker_pool import Lost

__all__ = ["Cluster"]

# Models that are handed out for each thread of the cluster: one is worked on, one is waiting.
_AHEAD = 2
# A model is lost when it has lost its worker this often.
_RETRIES = 2
_PATIENCE = 30


class Cluster:
    """The workers of a scheduler; use as a context manager.

    All of them see the files of the batch under the same names, and have the same version of meshmark.
    """

    def __init__(self, address: str, function: Callable[[Item], Row | Lost]) -> None:
        """Connect to a scheduler; raises `InputError` where Dask is missing or the scheduler does not answer."""
        try:
            from distributed import Client
        except ImportError:
            raise InputError("a cluster needs Dask: pip install meshmark[distributed]") from None
        try:
            connect: Any = Client
            self._client: Any = connect(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(f"the scheduler {address} does not answer: {error}") from None
        self.address, self.function = address, function
        self._busy: dict[Any, Item] = {}

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()

    @property
    def free(self) -> int:
        """Return how many models can be handed out now; at least one waits for a worker."""
        threads = int(sum(self._client.nthreads().values()))
        return max(_AHEAD * threads, 1) - len(self._busy)

    @property
    def busy(self) -> int:
        """Return how many models are with the cluster."""
        return len(self._busy)

    def submit(self, job: Item) -> None:
        """Hand out a model."""
        future = self._client.submit(self.function, job, pure=False, retries=_RETRIES)
        self._busy[future] = job

    def finished(self) -> list[tuple[Item, Row | Lost]]:
        """Wait until a model is done, and return those that are.

        Raises `OutputError` where the scheduler is gone.
        """
        import distributed

        wait: Any = distributed.wait
        try:
            with self._client.as_current():
                ended = wait(list(self._busy), return_when="FIRST_COMPLETED").done
        except (OSError, asyncio.CancelledError):
            raise self._gone() from None
        return [(self._busy.pop(future), self._outcome(future)) for future in ended]

    def _outcome(self, future: Any) -> Row | Lost:
        if future.status == "cancelled":
            raise self._gone()
        error = future.exception()
        if error is None:
            outcome: Row | Lost = future.result()
            return outcome
        return Lost(
            why="killed", note=" ".join(f"its worker failed: {type(error).__name__}: {error}".split())
        )

    def _gone(self) -> OutputError:
        return OutputError(f"the scheduler {self.address} is gone; --resume goes on with another")
