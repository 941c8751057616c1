"""A whole run: every case of a suite becomes a row in the store, also where a start before this one was cut off."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from meshmark.benchmark.crew import Crew
from meshmark.benchmark.facts import Facts, cores, facts_of_now, memory_mb
from meshmark.benchmark.job import Job, Look, Mark, Outcome, mark_of, needs
from meshmark.benchmark.marks import clear_unfinished, mark_path
from meshmark.benchmark.models import choose, find_models, split_of, write_shipped
from meshmark.benchmark.row import Case, Row
from meshmark.benchmark.schedule import Schedule
from meshmark.benchmark.store import Store
from meshmark.benchmark.suites import SUITES, cases
from meshmark.benchmark.worker import Setup
from meshmark.errors import InputError, OutputError
from meshmark.schemes import SCHEMES

__all__ = ["Finished", "Plan", "run"]

# Of the memory of the machine, what all workers together may use.
_MEMORY_SHARE = 0.8


@dataclass(frozen=True)
class Plan:
    """What to run. data: None for the models that come with the package; limit: of models, None for all.

    workers: None for one on each core; time_limit: of one job, seconds.
    """

    suite: str
    data: Path | None
    out: Path
    schemes: tuple[str, ...] = ("ncdg_lv",)
    limit: int | None = None
    seed: int = 0
    workers: int | None = None
    time_limit: float = 600.0


@dataclass(frozen=True)
class Finished:
    """The rows of a run, the facts of it, and how many rows an earlier start had left."""

    rows: list[Row]
    facts: Facts
    resumed: int


def run(plan: Plan, told: Callable[[int, int, int], None] = lambda *_: None) -> Finished:
    """Do what is left to do; `told(done, total, failed)` is called after each row.

    Raises `InputError` for a plan that cannot be, or a folder that holds another run, `OutputError` for one
    that cannot be written.
    """
    _check(plan)
    try:
        plan.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {plan.out}: {error.strerror}") from None
    data = plan.out / "models" if plan.data is None else plan.data
    if plan.data is None:
        write_shipped(data)
    models = choose(data, find_models(data), plan.limit)
    workers = plan.workers or cores()
    setup = Setup(data.resolve(), plan.out.resolve(), int(_MEMORY_SHARE * memory_mb()) // workers)
    titles = {name: f"{SCHEMES[name].title} ({SCHEMES[name].source})" for name in plan.schemes}
    limits = {"workers": workers, "time_limit": plan.time_limit, "worker_memory_mb": setup.worker_memory_mb}
    facts = facts_of_now(plan.suite, plan.seed, titles, setup.data, len(models), **limits)
    wanted = [
        case
        for model in models
        for name in plan.schemes
        for case in cases(plan.suite, name, model, plan.seed)
    ]
    with Store(plan.out) as store:
        store.begin(facts)
        clear_unfinished(plan.out)
        held = store.cases()
        left = [case for case in wanted if case not in held]
        with Crew(workers, setup, plan.time_limit) as crew:
            _Run(store, crew, left, len(wanted), told).go()
        return Finished(store.rows(), store.facts() or facts, len(wanted) - len(left))


def _check(plan: Plan) -> None:
    if plan.suite not in SUITES:
        raise InputError(f"'{plan.suite}' is not a suite, expected one of {', '.join(SUITES)}")
    for name in plan.schemes:
        if name not in SCHEMES:
            raise InputError(f"'{name}' is not a scheme, expected one of {', '.join(SCHEMES)}")
    if plan.workers is not None and plan.workers < 1:
        raise InputError(f"the number of workers is {plan.workers}, expected at least 1")
    if plan.time_limit <= 0:
        raise InputError(f"the time limit is {plan.time_limit:g} s, expected more than 0")


class _Run:
    """The loop between schedule, crew and store."""

    def __init__(
        self, store: Store, crew: Crew, left: list[Case], total: int, told: Callable[[int, int, int], None]
    ) -> None:
        self.store, self.crew, self.told = store, crew, told
        self.done, self.total, self.failed = total - len(left), total, 0
        self.schedule = Schedule(left, self._known(left))
        self.start = perf_counter()

    def go(self) -> None:
        self._keep(self.schedule.fallen())
        while self.schedule or self.crew.busy:
            while self.schedule and self.crew.free:
                self.crew.submit(self.schedule.take())
            for job, outcome in self.crew.finished():
                if isinstance(job, Case):
                    self._keep([(job, outcome)])
                else:
                    self.store.add_job(job, outcome)
                self.schedule.done(job, outcome)
            self._keep(self.schedule.fallen())
            self.store.spent(perf_counter() - self.start)

    def _known(self, left: Iterable[Case]) -> dict[Job, Outcome]:
        """Return the outcomes of models and marks from an earlier start, but for marks that are gone."""
        known: dict[Job, Outcome] = {}
        for job in {job for case in left for job in (*needs(case), mark_of(case))}:
            if isinstance(job, Look | Mark) and (outcome := self.store.job(job)) is not None:
                gone = (
                    isinstance(job, Mark)
                    and outcome.status == "ok"
                    and not mark_path(self.store.folder, job).exists()
                )
                if not gone:
                    known[job] = outcome
        return known

    def _keep(self, ended: Iterable[tuple[Case, Outcome]]) -> None:
        for case, outcome in ended:
            self.store.add_row(self._row(case, outcome))
            self.done += 1
            self.failed += outcome.status not in ("ok", "refused")
            self.told(self.done, self.total, self.failed)

    def _row(self, case: Case, outcome: Outcome) -> Row:
        """Put together what is known of the model, of the mark, and of the case."""
        parts = [self.schedule.outcomes.get(Look(case.model))]
        if case.trial in ("marked", "wrong key"):
            parts.append(self.schedule.outcomes.get(mark_of(case)))
        ended = [part for part in (*parts, outcome) if part]
        figures = {name: value for part in ended for name, value in part.figures.items()}
        peaks = [part.figures["peak_mb"] for part in ended if part.figures.get("peak_mb")]
        figures["peak_mb"] = max(peaks, default=None)
        return Row(case, outcome.status, outcome.note, split=split_of(case.model), **figures)
