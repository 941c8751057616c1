"""The kinds of work of a benchmark: look, mark, judge a case, probe; and what each needs done first."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from meshmark.attacks.chain import parse_chain
from meshmark.research import SCHEMES
from meshmark.research.benchmark.run.row import Case
from meshmark.research.benchmark.run.suites import SUITES
from meshmark.research.schemes.outside import FILE_ENDING, file_digest
from meshmark.research.schemes.scheme import SharedMark

__all__ = [
    "Job",
    "Look",
    "Mark",
    "Outcome",
    "Probe",
    "mark_of",
    "marks_of",
    "model_of",
    "needs",
    "shared_mark",
]


@dataclass(frozen=True, order=True)
class Look:
    """Read a model: its size, the time to read and write it, and whether it can be read at all."""

    model: str


@dataclass(frozen=True, order=True, kw_only=True)
class Mark:
    """Mark a model. Scheme, `owner` (the model whose key it is), budget, seed and fresh name the key.

    Of several schemes that read the same marks it is the blind one. The payload has a number besides: 0 is judged,
    1, 2, ... are further copies. A `donor` is the model that comes with the package, marked with the owner's key.
    fresh: the repeat that has a mark of its own, else 0.
    """

    scheme: str
    owner: str
    budget: str
    seed: int
    fresh: int = 0
    number: int = 0
    donor: bool = False


@dataclass(frozen=True, order=True, kw_only=True)
class Probe:
    """Measure something of a model that is no reading of a scheme: `kind` is a name in `probes.PROBES`."""

    kind: str
    model: str
    seed: int


Job = Look | Mark | Probe | Case


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How a job ended: a status of `Row` with its sentence, and the fields of `Row` it fills, or a probe's own."""

    status: str
    note: str = ""
    figures: dict[str, Any] = field(default_factory=dict)


def shared_mark(scheme: str) -> SharedMark | None:
    """Return whose marks a scheme reads, None for its own."""
    return _shared_mark(scheme, file_digest(scheme) if scheme.endswith(FILE_ENDING) else "")


@lru_cache(maxsize=64)
def _shared_mark(scheme: str, _digest: str) -> SharedMark | None:
    if scheme not in SCHEMES:
        return None
    shared = getattr(SCHEMES[scheme], "shared_mark", None)
    return shared if isinstance(shared, SharedMark) else None


def mark_of(case: Case) -> Mark:
    """Return the mark of a case's model that is judged, or that names the key where there is none."""
    fresh = case.repeat if SUITES[case.suite].fresh else 0
    shared = shared_mark(case.scheme)
    scheme = case.scheme if shared is None else shared.scheme
    return Mark(scheme=scheme, owner=case.model, budget=case.budget, seed=case.seed, fresh=fresh)


def marks_of(case: Case) -> list[Mark]:
    """Return the marks that a case cannot do without: its own first, then the attacker's copies or the donor."""
    main = mark_of(case)
    chain = parse_chain(case.attack)
    marks = [] if case.trial in ("unmarked", "forged") else [main]
    if "copies" in chain.needs:
        marks += [_variant(main, number) for number in range(1, _colluders(case.attack))]
    if "donor" in chain.needs:
        marks.append(_variant(main, 0, donor=True))
    return marks


def needs(job: Job) -> list[Job]:
    """Return the jobs that must have ended well before this one."""
    if isinstance(job, Look):
        return []
    if isinstance(job, Mark | Probe):
        return [Look(model_of(job))]
    return [Look(job.model), *marks_of(job)]


def model_of(job: Job) -> str:
    """Return the model that a job works on."""
    return job.owner if isinstance(job, Mark) else job.model


def _variant(mark: Mark, number: int, donor: bool = False) -> Mark:
    return Mark(
        scheme=mark.scheme,
        owner=mark.owner,
        budget=mark.budget,
        seed=mark.seed,
        fresh=mark.fresh,
        number=number,
        donor=donor,
    )


def _colluders(attack: str) -> int:
    """Return how many copies the largest collusion of a chain averages."""
    return max(int(strength) for name, strength in parse_chain(attack).steps if name == "collusion")
