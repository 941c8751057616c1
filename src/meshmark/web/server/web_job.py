"""One job: what it is at, and what came of it."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

from meshmark.web.server.orders import Order

__all__ = ["Download", "State", "WebJob"]


class State(StrEnum):
    """What a job is at."""

    queued = "queued"
    running = "running"
    done = "done"
    failed = "failed"
    cancelled = "cancelled"


@dataclass(frozen=True, kw_only=True)
class Download:
    """A file that a job made. kind: what it is; name: what it is saved as; path: where it is; bytes: its size."""

    kind: str
    name: str
    path: Path
    bytes: int


@dataclass(eq=False, kw_only=True)
class WebJob:
    """A job from the moment when its files are there; changed by the queue alone.

    id: cannot be guessed, so that knowing it is what allows to see the job. large: whether it counts as large.
    answer: the fields that the command line prints with --json; exit_code: the command's. words: the answer in
    plain words, remarks: what the command said beside it.
    view: file of what the interactive view shows, None without one.
    """

    id: str
    folder: Path
    order: Order
    command: list[str]
    large: bool
    state: State = State.queued
    stage: str = "waiting"
    made: float = field(default_factory=time.monotonic)
    started: float | None = None
    ended: float | None = None
    exit_code: int | None = None
    answer: dict[str, Any] | None = None
    words: str = ""
    remarks: list[str] = field(default_factory=list)
    downloads: dict[str, Download] = field(default_factory=dict)
    view: Path | None = None

    @property
    def is_over(self) -> bool:
        """Return whether nothing will change any more."""
        return self.state in (State.done, State.failed, State.cancelled)

    @property
    def seconds(self) -> float:
        """Return for how long the job has been, or was, worked on."""
        if self.started is None:
            return 0.0
        return (self.ended or time.monotonic()) - self.started

    @property
    def error(self) -> dict[str, Any] | None:
        """Return the fields of the error that ended the job, None without one."""
        return None if self.answer is None else self.answer.get("error")
