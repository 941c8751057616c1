"""A whole run: every case of a suite becomes a row in the store, also where a start before this one was cut off."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import inf
from pathlib import Path
from time import perf_counter

from meshmark.errors import InputError, OutputError
from meshmark.research import SCHEMES
from meshmark.research.benchmark.run.facts import Facts, cores, facts_of_now, memory_mb
from meshmark.research.benchmark.run.job import (
    Job,
    Look,
    Mark,
    Outcome,
    Probe,
    mark_of,
    model_of,
    needs,
    shared_mark,
)
from meshmark.research.benchmark.run.marked_models import clear_unfinished, mark_path
from meshmark.research.benchmark.run.model_files import find_models, split_of, spread, write_shipped
from meshmark.research.benchmark.run.row import Case, Row
from meshmark.research.benchmark.run.schedule import Schedule
from meshmark.research.benchmark.run.shared_readings import (
    answered_blind,
    blind_of,
    outcome_of,
    read_by_both,
)
from meshmark.research.benchmark.run.store import Store
from meshmark.research.benchmark.run.suites import SUITES, cases
from meshmark.research.benchmark.run.worker import Setup, ended, work
from meshmark.workers.worker_pool import WorkerPool

__all__ = ["Finished", "Plan", "run", "schemes_of"]

# Of the memory of the machine, what all workers together may use.
_MEMORY_SHARE = 0.8


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What to run. data: None for the models that come with the package; limit: of models, None for all.

    schemes: names, files that end in .py, "all", or None for those that the suite is made for.
    workers: None for one on each core; time_limit: of one job, seconds. hours: after this time no model is begun.
    """

    suite: str
    data: Path | None
    out: Path
    schemes: tuple[str, ...] | None = None
    limit: int | None = None
    seed: int = 0
    workers: int | None = None
    time_limit: float = 600.0
    hours: float | None = None


@dataclass(frozen=True, kw_only=True)
class Finished:
    """The rows of a run, the facts of it, and how many rows an earlier start had left.

    probes: what was measured besides; left: cases that there was no time for.
    """

    rows: list[Row]
    facts: Facts
    resumed: int
    probes: Mapping[Probe, Outcome] = field(default_factory=dict)
    left: int = 0


def run(plan: Plan, progress: Callable[[int, int, int], None] = lambda *_: None) -> Finished:
    """Do what is left to do; `progress(done, total, failed)` is called after each row.

    Raises `InputError` for a plan that cannot be, or a folder that holds another run, `OutputError` for one
    that cannot be written.
    """
    names = schemes_of(plan)
    _check(plan)
    try:
        plan.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {plan.out}: {error.strerror}") from None
    data = plan.out / "models" if plan.data is None else plan.data
    if plan.data is None:
        write_shipped(data)
    models = spread(data, find_models(data))[: plan.limit]
    workers = plan.workers or cores()
    setup = Setup(
        data=data.resolve(),
        out=plan.out.resolve(),
        worker_memory_mb=int(_MEMORY_SHARE * memory_mb()) // workers,
        schemes=names,
    )
    titles = {name: SCHEMES.described(name) for name in names}
    limits = {"workers": workers, "time_limit": plan.time_limit, "worker_memory_mb": setup.worker_memory_mb}
    facts = facts_of_now(plan.suite, plan.seed, titles, setup.data, len(models), **limits)
    wanted = list(_wanted(plan, models, names))
    with Store(plan.out) as store:
        store.begin(facts)
        clear_unfinished(plan.out)
        held = store.cases() | store.probes().keys()
        left = [job for job in wanted if job not in held]
        with _pool(workers, setup, plan.time_limit) as pool:
            undone = _Run(store, pool, left, len(wanted), names, progress, plan.hours).go()
        rows, kept = store.rows(), store.facts() or facts
        return Finished(
            rows=rows, facts=kept, resumed=len(wanted) - len(left), probes=store.probes(), left=undone
        )


def _pool(workers: int, setup: Setup, time_limit: float) -> WorkerPool[Job, Outcome]:
    return WorkerPool(
        workers,
        partial(work, setup),
        time_limit=time_limit,
        memory_mb=setup.worker_memory_mb,
        preload="meshmark.research.benchmark.run.worker",
    )


def schemes_of(plan: Plan) -> tuple[str, ...]:
    """Return the names of the schemes of a plan; raises `InputError` for one that is not a scheme."""
    if plan.suite not in SUITES:
        raise InputError(f"'{plan.suite}' is not a suite, expected one of {', '.join(SUITES)}")
    if plan.schemes is None:
        return tuple(name for name in SUITES[plan.suite].schemes if name in SCHEMES)
    named = (tuple(SCHEMES) if name == "all" else (name,) for name in plan.schemes)
    names = tuple(dict.fromkeys(name for group in named for name in group))
    for name in names:
        if name not in SCHEMES:
            known = ", ".join([*SCHEMES, "all", "a file .py"])
            raise InputError(f"'{name}' is not a scheme, expected one of {known}")
        _check_shared(name)
    return names


def _check_shared(name: str) -> None:
    """Raise `InputError` for a scheme that reads the marks of another, unless that is blind and as long."""
    shared = shared_mark(name)
    if shared is None:
        return
    other = SCHEMES.get(shared.scheme)
    if other is None or not other.blind or other.bits != SCHEMES[name].bits:
        raise InputError(
            f"'{name}' reads the marks of '{shared.scheme}', expected a blind scheme of {SCHEMES[name].bits} bits"
        )


def _wanted(plan: Plan, models: Iterable[str], names: Iterable[str]) -> Iterator[Case | Probe]:
    for model in models:
        yield from (Probe(kind=kind, model=model, seed=plan.seed) for kind in SUITES[plan.suite].probes)
        for name in names:
            yield from cases(plan.suite, name, model, plan.seed)


def _check(plan: Plan) -> None:
    if plan.limit is not None and plan.limit < 1:
        raise InputError(f"the limit is {plan.limit}, expected at least 1 model")
    if plan.hours is not None and plan.hours <= 0:
        raise InputError(f"the time for all is {plan.hours:g} hours, expected more than 0")
    if plan.workers is not None and plan.workers < 1:
        raise InputError(f"the number of workers is {plan.workers}, expected at least 1")
    if plan.time_limit <= 0:
        raise InputError(f"the time limit is {plan.time_limit:g} s, expected more than 0")


class _Run:
    """The loop between schedule, worker pool and store."""

    def __init__(
        self,
        store: Store,
        pool: WorkerPool[Job, Outcome],
        left: list[Case | Probe],
        total: int,
        names: tuple[str, ...],
        progress: Callable[[int, int, int], None],
        hours: float | None,
    ) -> None:
        self.store, self.pool, self.names, self.progress = store, pool, names, progress
        self.done, self.total, self.failed = total - len(left), total, 0
        self.schedule = Schedule(left, self._known(left), names)
        self.start = perf_counter()
        self.seconds = inf if hours is None else 3600.0 * hours
        self.begun: set[str] = set()

    def go(self) -> int:
        """Do the work and return how many cases and probes there was no time for."""
        self._keep(self.schedule.fallen())
        while True:
            while self.pool.free and self._more():
                job = self.schedule.take()
                self.begun.add(model_of(job))
                answered = self._answered(job)
                if answered is None:
                    self.pool.submit(job)
                else:
                    self._end(job, answered)
            if not self.pool.busy:
                return self.total - self.done
            for job, result in self.pool.finished():
                self._end(job, self._whole(job, ended(result)))
            self._keep(self.schedule.fallen())
            self.store.spent(perf_counter() - self.start)

    def _end(self, job: Job, outcome: Outcome) -> None:
        if isinstance(job, Case | Probe):
            self._keep([(job, outcome)])
        else:
            self.store.add_job(job, outcome)
        self.schedule.done(job, outcome)

    def _answered(self, job: Job) -> Outcome | None:
        """Return the outcome of a case whose blind reading was enough."""
        blind = self._read_blind(job)
        return answered_blind(job.scheme, blind) if isinstance(job, Case) and blind else None

    def _whole(self, job: Job, outcome: Outcome) -> Outcome:
        """Return the outcome of a job, with what was read blind if it is a reading with a reference."""
        blind = self._read_blind(job)
        return read_by_both(job.scheme, outcome, blind) if isinstance(job, Case) and blind else outcome

    def _read_blind(self, job: Job) -> Outcome | None:
        """Return what was read blind of the suspect of a reading with a reference; None for other jobs."""
        blind = blind_of(job, self.names)
        return None if blind is None else self.schedule.outcomes[blind]

    def _more(self) -> bool:
        """Return whether a job is to be given out: when the time is over, only for models that were begun."""
        if not self.schedule:
            return False
        return perf_counter() - self.start < self.seconds or model_of(self.schedule.peek()) in self.begun

    def _known(self, left: Iterable[Case | Probe]) -> dict[Job, Outcome]:
        """Return the outcomes of models and marks from an earlier start, but for marks that are gone."""
        known: dict[Job, Outcome] = {}
        wanted = {job for case in left for job in needs(case)}
        for job in wanted | {mark_of(case) for case in left if isinstance(case, Case)}:
            if isinstance(job, Look | Mark) and (outcome := self.store.job(job)) is not None:
                gone = (
                    isinstance(job, Mark)
                    and outcome.status == "ok"
                    and not mark_path(self.store.folder, job).exists()
                )
                if not gone:
                    known[job] = outcome
        blind = {blind_of(case, self.names) for case in left}
        known |= {row.case: outcome_of(row) for row in self.store.rows() if row.case in blind}
        return known

    def _keep(self, ended: Iterable[tuple[Case | Probe, Outcome]]) -> None:
        for job, outcome in ended:
            if isinstance(job, Case):
                self.store.add_row(self._row(job, outcome))
            else:
                self.store.add_job(job, outcome)
            self.done += 1
            self.failed += outcome.status not in ("ok", "refused")
            self.progress(self.done, self.total, self.failed)

    def _row(self, case: Case, outcome: Outcome) -> Row:
        """Put together what is known of the model, of the mark, and of the case."""
        parts = [self.schedule.outcomes.get(Look(case.model))]
        if case.trial in ("marked", "wrong key"):
            parts.append(self.schedule.outcomes.get(mark_of(case)))
        ended = [part for part in (*parts, outcome) if part]
        figures = {name: value for part in ended for name, value in part.figures.items()}
        peaks = [part.figures["peak_mb"] for part in ended if part.figures.get("peak_mb")]
        figures["peak_mb"] = max(peaks, default=None)
        return Row(case=case, status=outcome.status, note=outcome.note, split=split_of(case.model), **figures)
