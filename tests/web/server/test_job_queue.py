"""The queue: lanes, cancelling, limits and forgetting, with processes that stand for the real ones."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from meshmark.web.server import job_queue
from meshmark.web.server.command_process import ProcessDied
from meshmark.web.server.job_queue import JobQueue
from meshmark.web.server.orders import Action, Order
from meshmark.web.server.refusals import Refusal
from meshmark.web.server.settings import Settings
from meshmark.web.server.web_job import State, WebJob

FAULTS = {
    "die": ProcessDied("the process of this job crashed (SIGSEGV)"),
    "full": OSError("there are too many processes"),
}


class Process:
    """Stands for a process that runs a command: it ends when the test says so, or dies."""

    is_alive = True

    def __init__(self) -> None:
        self.go, self.killed = asyncio.Event(), False

    @classmethod
    async def start(cls) -> Process:
        return cls()

    async def run(self, job, told):
        line = job["command"][0]
        if line in FAULTS:
            raise FAULTS[line]
        told({"stage": line})
        if line != "quick":
            await self.go.wait()
        return {"code": 0, "words": "Done.", "answer": {"outputs": {}}}

    def kill(self) -> None:
        self.killed = True

    async def end(self) -> None:
        self.killed = True


@pytest.fixture(autouse=True)
def stand_ins(monkeypatch):
    monkeypatch.setattr(job_queue, "CommandProcess", Process)


def job(folder: Path, name: str, command: str = "slow", large: bool = False) -> WebJob:
    (folder / name).mkdir()
    order = Order(
        action=Action.embed,
        model=Path("in/a.ply"),
        key=Path("k"),
        certificate=None,
        original=None,
        options={},
    )
    return WebJob(id=name, folder=folder / name, order=order, command=[command], large=large)


def settings(folder: Path, **fields) -> Settings:
    return Settings(key_folder=folder, **fields)


async def until(condition) -> None:
    for _ in range(400):
        if condition():
            return
        await asyncio.sleep(0.005)
    raise TimeoutError


def test_a_small_job_does_not_wait_for_large_ones(tmp_path):
    async def scenario() -> list[State]:
        async with JobQueue(settings(tmp_path, workers=3)) as queue:
            jobs = [job(tmp_path, f"large{n}", large=True) for n in range(4)]
            jobs += [job(tmp_path, "small", "quick"), job(tmp_path, "other", "quick")]
            for each in jobs:
                queue.submit(each)
            await until(lambda: jobs[-1].is_over)
            return [each.state for each in jobs]

    running, queued, done = State.running, State.queued, State.done
    assert asyncio.run(scenario()) == [running, running, queued, queued, done, done]


def test_jobs_start_in_the_order_in_which_they_came(tmp_path):
    async def scenario() -> tuple[list[int | None], State]:
        async with JobQueue(settings(tmp_path, workers=2)) as queue:
            jobs = [job(tmp_path, str(n)) for n in range(5)]
            for each in jobs:
                queue.submit(each)
            places = [queue.position(each) for each in jobs]
            queue.cancel(jobs[0])
            await until(lambda: jobs[2].state is State.running)
            return places, jobs[3].state

    assert asyncio.run(scenario()) == ([None, None, 0, 1, 2], State.queued)


@pytest.mark.parametrize("running", [True, False])
def test_a_cancelled_job_is_forgotten_with_its_folder(tmp_path, running):
    async def scenario() -> None:
        async with JobQueue(settings(tmp_path, workers=2)) as queue:
            jobs = [job(tmp_path, str(n)) for n in range(3)]
            for each in jobs:
                queue.submit(each)
            await until(lambda: jobs[0].stage == "slow")
            cancelled = jobs[0 if running else 2]
            queue.cancel(cancelled)
            assert cancelled.state is State.cancelled
            await until(lambda: not cancelled.folder.exists())
            with pytest.raises(Refusal, match="there is no such job"):
                queue.find(cancelled.id)

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("fault", "kind", "sentence"),
    [("die", "worker", "SIGSEGV"), ("full", "bug", "a bug in meshmark (OSError)")],
)
def test_a_process_that_dies_fails_its_job_and_no_other(tmp_path, fault, kind, sentence):
    async def scenario() -> tuple[WebJob, WebJob]:
        async with JobQueue(settings(tmp_path)) as queue:
            dead, well = job(tmp_path, "dead", fault), job(tmp_path, "well", "quick")
            queue.submit(dead)
            queue.submit(well)
            await until(lambda: dead.is_over and well.is_over)
            return dead, well

    dead, well = asyncio.run(scenario())
    assert (dead.state, well.state) == (State.failed, State.done)
    assert dead.error["kind"] == kind
    assert sentence in dead.error["message"]


def test_a_job_that_takes_too_long_is_ended(tmp_path):
    async def scenario() -> WebJob:
        async with JobQueue(settings(tmp_path, job_seconds=0.02)) as queue:
            slow = job(tmp_path, "slow")
            queue.submit(slow)
            await until(lambda: slow.is_over)
            return slow

    slow = asyncio.run(scenario())
    assert (slow.state, slow.error["kind"]) == (State.failed, "time")


def test_finished_jobs_are_forgotten_after_their_time(tmp_path):
    async def scenario() -> None:
        async with JobQueue(settings(tmp_path, kept_seconds=0.02)) as queue:
            quick, slow = job(tmp_path, "quick", "quick"), job(tmp_path, "slow")
            queue.submit(quick)
            queue.submit(slow)
            await until(lambda: not quick.folder.exists())
            assert slow.folder.exists()
            assert queue.find("slow") is slow

    asyncio.run(scenario())


def test_more_jobs_than_there_is_room_for_are_refused(tmp_path):
    async def scenario() -> None:
        async with JobQueue(settings(tmp_path, waiting=2)) as queue:
            queue.check_room()
            queue.submit(job(tmp_path, "a"))
            queue.submit(job(tmp_path, "b"))
            with pytest.raises(Refusal, match="too many jobs"):
                queue.check_room()

    asyncio.run(scenario())
