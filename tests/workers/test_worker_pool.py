"""A job that crashes, hangs or eats memory is lost alone; an ended worker costs a job another try."""

from __future__ import annotations

import os
import signal
import time
from concurrent.futures.process import BrokenProcessPool
from contextlib import nullcontext
from pathlib import Path

import pebble
import pytest

from meshmark.errors import OutputError
from meshmark.workers import worker_pool
from meshmark.workers.worker_pool import Lost, WorkerPool


def work(job: str) -> str:
    """Do what the job says."""
    kind, _, place = job.partition(" ")
    if kind == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if kind == "hang":
        time.sleep(60)
    if kind == "eat":
        return str(len(b"x" * (400 << 20)))
    if kind == "once" and not Path(place).exists():
        Path(place).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return kind


def outcomes(jobs: list[str], seconds: float = 30.0) -> dict[str, object]:
    found: dict[str, object] = {}
    pool: WorkerPool[str, str] = WorkerPool(
        2, work, time_limit=seconds, memory_mb=300, preload="meshmark.workers.preparation"
    )
    with pool:
        left = list(jobs)
        while left or pool.busy:
            while left and pool.free:
                pool.submit(left.pop(0))
            found |= dict(pool.finished())
    return found


@pytest.mark.skipif(os.name != "posix", reason="there are no such signals")
def test_misfortune_harms_no_other_job(tmp_path):
    jobs = ["one", "crash", "two", f"once {tmp_path / 'begun'}", "three"]
    found = outcomes(jobs)
    assert found.keys() == set(jobs)
    assert found["crash"] == Lost(why="killed", note="the worker was ended by SIGSEGV")
    assert [found[each] for each in (jobs[0], jobs[2], jobs[3], jobs[4])] == ["one", "two", "once", "three"]


@pytest.mark.parametrize("broken", [1, 3])
def test_a_pool_that_breaks_before_its_job_is_renewed(monkeypatch, broken):
    times = []
    real = pebble.ProcessPool.schedule

    def schedule(pool, *arguments, **options):
        times.append(pool)
        if len(times) <= broken:
            raise BrokenProcessPool("killed while it was started")
        return real(pool, *arguments, **options)

    monkeypatch.setattr(pebble.ProcessPool, "schedule", schedule)
    monkeypatch.setattr(worker_pool, "_PAUSE", 0.0)
    expected = nullcontext() if broken < 3 else pytest.raises(OutputError, match="no worker process")
    with expected:
        assert outcomes(["one"]) == {"one": "one"}
    assert len(set(map(id, times))) == len(times) == max(broken, 2)


def test_a_job_that_hangs_is_given_up():
    found = outcomes(["hang", "one"], seconds=2.0)
    assert found == {"hang": Lost(why="timeout", note="took longer than 2 s"), "one": "one"}
