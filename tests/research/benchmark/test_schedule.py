"""The order of jobs: each after what it needs, and none after what failed."""

from __future__ import annotations

import random

import pytest

from meshmark.research.benchmark.run.job import Look, Outcome, mark_of, marks_of, needs
from meshmark.research.benchmark.run.row import Case
from meshmark.research.benchmark.run.schedule import Schedule
from meshmark.research.benchmark.run.suites import cases
from tests.counting import some

OK = Outcome(status="ok")
ALL = [case for model in ("a", "b", "c") for case in cases("security", "toy", model, 0)]


def played(schedule, outcome, width, seed=0):
    """Give out jobs to `width` workers that finish in any order; return jobs and fallen cases as they came."""
    chance, running, given, fallen, early = random.Random(seed), [], [], schedule.fallen(), []
    while schedule or running:
        while schedule and len(running) < width:
            job = schedule.take()
            early += [job for other in needs(job) if schedule.outcomes[other].status != "ok"]
            running.append(job)
            given.append(job)
        job = running.pop(chance.randrange(len(running)))
        schedule.done(job, outcome(job))
        fallen += schedule.fallen()
    assert early == [], "given out before what it needs"
    return given, fallen


@pytest.mark.parametrize("width", [1, 2, 7, 99])
def test_every_job_is_given_out_once_after_what_it_needs(width):
    given, fallen = played(Schedule(ALL, {}), lambda _: OK, width, seed=width)
    marks = {mark for case in ALL for mark in marks_of(case)}
    assert len(given) == len(set(given))
    assert set(given) == {*ALL, *marks, Look("a"), Look("b"), Look("c")}
    assert fallen == []


def test_one_worker_keeps_the_order_of_the_cases():
    given, _ = played(Schedule(ALL, {}), lambda _: OK, 1)
    assert [job for job in given if isinstance(job, Case)] == ALL
    models = [getattr(job, "owner", None) or job.model for job in given]
    assert models == sorted(models), "one model after the other"


@pytest.mark.parametrize("status", ["failed", "timeout", "killed"])
def test_a_model_that_cannot_be_read_takes_its_cases_along(status):
    bad = Outcome(status=status, note="why")
    given, fallen = played(Schedule(ALL, {}), lambda job: bad if job == Look("b") else OK, 2)
    assert sorted(fallen, key=lambda each: each[0]) == [
        (case, bad) for case in sorted(ALL) if case.model == "b"
    ]
    assert {job.model for job in given if isinstance(job, Case)} == {"a", "c"}
    assert not any(getattr(job, "owner", "") == "b" for job in some(given))


def test_a_refused_mark_takes_along_only_what_needs_it():
    refused = mark_of(next(case for case in ALL if case.model == "a"))
    given, fallen = played(
        Schedule(ALL, {}), lambda job: Outcome(status="refused") if job == refused else OK, 3
    )
    lost = [case for case in ALL if refused in marks_of(case)]
    assert sorted(case for case, _ in fallen) == sorted(lost)
    assert {case.trial for case in lost} == {"marked", "wrong key"}
    assert set(ALL) - set(lost) <= set(given)


def test_a_copy_that_fails_takes_along_only_the_collusions():
    lost_copy = marks_of(next(case for case in ALL if case.attack == "collusion:5"))[3]
    _, fallen = played(Schedule(ALL, {}), lambda job: Outcome(status="killed") if job == lost_copy else OK, 3)
    assert [case.attack for case, _ in fallen] == ["collusion:5"]


def test_what_an_earlier_start_has_done_is_not_given_out_again():
    first = mark_of(ALL[0])
    known = {Look("a"): OK, first: OK, Look("b"): Outcome(status="failed", note="torn")}
    given, fallen = played(Schedule(ALL, known), lambda _: OK, 2)
    assert not set(known) & set(given)
    assert {case for case, _ in fallen} == {case for case in ALL if case.model == "b"}
    assert {case for case in ALL if case.model != "b"} <= set(given)


def test_nothing_to_do():
    assert not Schedule([], {})
