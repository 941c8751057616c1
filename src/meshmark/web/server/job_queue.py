"""The jobs of a server: who waits, who is worked on, in which process, and when a job is forgotten.

Each job runs in a process of its own that was started ahead. Of `workers` jobs at once at least one is small, so
that small models do not wait for large ones. All methods run in the server's event loop, which nothing here blocks.
"""

from __future__ import annotations

import asyncio
import time
from functools import partial
from pathlib import Path
from typing import Any

from meshmark.web.server.command_process import CommandProcess, ProcessDied
from meshmark.web.server.job_folders import remove_folder
from meshmark.web.server.produced import downloads_of, own_names, view_of
from meshmark.web.server.refusals import Refusal, error_fields
from meshmark.web.server.settings import Settings
from meshmark.web.server.web_job import State, WebJob

__all__ = ["JobQueue"]

_SWEEP_SECONDS = 15.0


class JobQueue:
    """All jobs of a server; use as an asynchronous context manager."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._jobs: dict[str, WebJob] = {}
        self._waiting: list[WebJob] = []
        self._running: dict[str, asyncio.Task[None]] = {}
        self._spare: list[CommandProcess] = []
        self._tasks: set[asyncio.Task[None]] = set()

    async def __aenter__(self) -> JobQueue:
        """Start processes ahead, and what forgets old jobs."""
        for _ in range(self._settings.workers):
            self._background(self._add_spare())
        self._background(self._sweep())
        return self

    async def __aexit__(self, *_: object) -> None:
        """Kill all processes; what waits does not begin."""
        self._waiting.clear()
        ended = [*self._running.values(), *self._tasks]
        for task in ended:
            task.cancel()
        await asyncio.gather(*ended, return_exceptions=True)
        for process in self._spare:
            await process.end()

    def check_room(self) -> None:
        """Raise `Refusal` where too many jobs have not ended."""
        if len(self._waiting) + len(self._running) >= self._settings.waiting:
            raise Refusal(429, "too many jobs are waiting, try again later")

    def submit(self, job: WebJob) -> None:
        """Take a job whose files are there."""
        self._jobs[job.id] = job
        self._waiting.append(job)
        self._dispatch()

    def find(self, identity: str) -> WebJob:
        """Return a job; raises `Refusal` where there is none, or not any more."""
        job = self._jobs.get(identity)
        if job is None:
            raise Refusal(404, "there is no such job, or it was removed after its time")
        return job

    def position(self, job: WebJob) -> int | None:
        """Return how many jobs are before one that waits, None for others."""
        return self._waiting.index(job) if job in self._waiting else None

    def cancel(self, job: WebJob) -> None:
        """End a job and forget it with its files: its process is killed."""
        if job in self._waiting:
            self._waiting.remove(job)
        if not job.is_over:
            job.state, job.stage, job.ended = State.cancelled, "cancelled", time.monotonic()
        task = self._running.get(job.id)
        if task is None:
            self._forget(job)
        else:
            task.cancel()  # `_ended` forgets it

    def _dispatch(self) -> None:
        """Start what can be started, in the order in which jobs came."""
        for job in list(self._waiting):
            if len(self._running) >= self._settings.workers:
                return
            large = sum(self._jobs[identity].large for identity in self._running)
            if job.large and large >= self._settings.workers - 1:
                continue
            self._waiting.remove(job)
            job.state, job.stage, job.started = State.running, "starting", time.monotonic()
            task = asyncio.get_running_loop().create_task(self._run(job))
            self._running[job.id] = task
            task.add_done_callback(partial(self._ended, job))  # also of one that was cancelled at once

    async def _run(self, job: WebJob) -> None:
        process: CommandProcess | None = None
        try:
            process = await self._take_spare()
            async with asyncio.timeout(self._settings.job_seconds):
                found = await process.run(self._message(job), lambda message: _hear(job, message))
            await asyncio.to_thread(self._finish, job, found)
        except TimeoutError:
            most = f"{self._settings.job_seconds:.0f} seconds, the most that this server allows"
            _fail(job, "time", f"the job took longer than {most}")
        except ProcessDied as error:
            _fail(job, error.kind, str(error))
        except Exception as error:  # whatever it is, a job must not go on for ever
            _fail(job, "bug", f"this is a bug in meshmark ({type(error).__name__})")
        finally:
            if process is not None:
                process.kill()
                await process.end()

    def _ended(self, job: WebJob, _: asyncio.Task[None]) -> None:
        """Let the next job begin after one."""
        job.ended = job.ended or time.monotonic()
        self._running.pop(job.id, None)
        if job.state is State.cancelled:
            self._forget(job)
        self._dispatch()

    def _message(self, job: WebJob) -> dict[str, Any]:
        return {
            "folder": str(job.folder),
            "command": job.command,
            "memory": self._settings.job_bytes,
            "large": job.large,
            "registry": self._settings.registry,
        }

    def _finish(self, job: WebJob, found: dict[str, Any]) -> None:
        """Keep what a job came to. Its state is set last: who sees it sees the rest."""
        homes = (job.folder, self._settings.key_folder)
        job.exit_code, job.words = found["code"], own_names(found["words"], homes)
        job.remarks = [own_names(line, homes) for line in job.remarks]
        job.answer = own_names(found["answer"], homes)
        job.downloads = {each.name: each for each in downloads_of(job.folder, found["answer"])}
        job.view = view_of(job.downloads.values(), job.folder)
        job.ended = time.monotonic()
        if job.state is not State.cancelled:
            job.state, job.stage = (State.failed, "failed") if job.error else (State.done, "done")

    async def _take_spare(self) -> CommandProcess:
        """Return a process that has not begun, and start another one for the next."""
        while self._spare:
            process = self._spare.pop(0)
            if process.is_alive:
                self._background(self._add_spare())
                return process
        return await CommandProcess.start()

    async def _add_spare(self) -> None:
        if len(self._spare) < self._settings.workers:
            self._spare.append(await CommandProcess.start())

    async def _sweep(self) -> None:
        """Forget jobs whose time is over, again and again."""
        while True:
            await asyncio.sleep(min(_SWEEP_SECONDS, self._settings.kept_seconds))
            oldest = time.monotonic() - self._settings.kept_seconds
            for job in list(self._jobs.values()):
                if job.is_over and job.ended is not None and job.ended < oldest:
                    self._forget(job)

    def _forget(self, job: WebJob) -> None:
        self._jobs.pop(job.id, None)
        self._background(asyncio.to_thread(remove_folder, Path(job.folder)))

    def _background(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _hear(job: WebJob, message: dict[str, Any]) -> None:
    if "stage" in message:
        job.stage = message["stage"]
    if "remark" in message:
        job.remarks.append(message["remark"])


def _fail(job: WebJob, kind: str, sentence: str) -> None:
    job.answer, job.exit_code = error_fields(kind, sentence), 2
    job.ended = time.monotonic()
    job.state, job.stage = State.failed, "failed"
