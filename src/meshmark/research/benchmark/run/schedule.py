"""What can be done next: a case waits for its model and marks, and falls with them."""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterable, Mapping

from meshmark.research.benchmark.run.job import Job, Outcome, Probe, needs
from meshmark.research.benchmark.run.row import Case
from meshmark.research.benchmark.run.shared_readings import blind_of

__all__ = ["Schedule"]


class Schedule:
    """The jobs that some cases and probes ask for, each given out when what it needs is done, in their order.

    known: outcomes from an earlier start; those jobs are not given out again. schemes: all that are measured.
    """

    def __init__(
        self, cases: Iterable[Case | Probe], known: Mapping[Job, Outcome], schemes: Collection[str] = ()
    ) -> None:
        """Plan all jobs of the cases and probes."""
        self.outcomes = dict(known)
        self._schemes = schemes
        self._place: dict[Job, int] = {}
        self._waits: dict[Job, set[Job]] = {}
        self._blocks: dict[Job, list[Job]] = {}
        self._ready: list[tuple[int, Job]] = []
        self._fallen: list[tuple[Case | Probe, Outcome]] = []
        for case in cases:
            self._plan(case)

    def __bool__(self) -> bool:
        """Return whether a job can be given out now."""
        return bool(self._ready)

    def peek(self) -> Job:
        """Return the next job."""
        return self._ready[0][1]

    def take(self) -> Job:
        """Return the next job and mark it as given out."""
        return heapq.heappop(self._ready)[1]

    def fallen(self) -> list[tuple[Case | Probe, Outcome]]:
        """Return the cases and probes that cannot be done any more, each with the outcome that it shares; once."""
        fallen, self._fallen = self._fallen, []
        return fallen

    def done(self, job: Job, outcome: Outcome) -> None:
        """Note how a job ended, which frees what waited for it, or ends it too."""
        self.outcomes[job] = outcome
        for waiting in self._blocks.pop(job, []):
            if outcome.status != "ok" and job in needs(waiting):
                self._fall(waiting, outcome)
            elif waiting in self._waits:
                self._waits[waiting].discard(job)
                self._offer(waiting)

    def _plan(self, job: Job) -> None:
        if job in self._place or job in self.outcomes:
            return
        required = needs(job)
        # However it ends, what is read blind comes before what is read with a reference.
        blind = blind_of(job, self._schemes)
        waits = required if blind is None else [*required, blind]
        for other in waits:
            self._plan(other)
        self._place[job] = len(self._place)
        failed = [self.outcomes[other] for other in required if self._failed(other)]
        if failed:
            self._fall(job, failed[0])
            return
        self._waits[job] = {other for other in waits if other not in self.outcomes}
        for other in self._waits[job]:
            self._blocks.setdefault(other, []).append(job)
        self._offer(job)

    def _failed(self, job: Job) -> bool:
        return job in self.outcomes and self.outcomes[job].status != "ok"

    def _offer(self, job: Job) -> None:
        if not self._waits[job]:
            del self._waits[job]
            heapq.heappush(self._ready, (self._place[job], job))

    def _fall(self, job: Job, outcome: Outcome) -> None:
        self._waits.pop(job, None)
        if job in self.outcomes:
            return
        if isinstance(job, Case | Probe):
            self._fallen.append((job, outcome))
        self.done(job, outcome)
