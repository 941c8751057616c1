"""A progress bar for long work, drawn by rich: on a terminal only, after a moment, and wiped when the work ends.

rich is imported when there is something to draw, so commands in pipes and quick ones do not wait for it.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from meshmark.cli.listening import listener

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn

__all__ = ["counted", "progress"]

# Work shorter than this shows nothing; seconds.
_PATIENCE = 0.8
_REDRAW = 0.1
_WIDTH = 24
# Without a terminal, a line after this many cases.
_LINE_EVERY = 100


@contextmanager
def progress(label: str) -> Iterator[None]:
    """Show that `label` is going on, and for how long, while the block runs.

    The length of a search or a solve is not known beforehand, so the bar pulses instead of filling up.
    """
    heard = listener()
    if heard is not None:
        heard.stage(label)
    if heard is not None or not sys.stderr.isatty():
        yield
        return
    done = threading.Event()
    painter = threading.Thread(target=_paint, args=(label, done), daemon=True)
    painter.start()
    try:
        yield
    finally:
        done.set()
        painter.join()


def _paint(label: str, done: threading.Event) -> None:
    if done.wait(_PATIENCE):
        return
    from rich.progress import TimeElapsedColumn

    with _bar(TimeElapsedColumn()) as bar:
        bar.add_task(label, total=None)
        done.wait()


def _bar(*columns: ProgressColumn, live: bool = True) -> Progress:
    """Return a bar, its description, and further columns; live: redrawn by a thread of its own."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    return Progress(
        BarColumn(_WIDTH),
        TextColumn("{task.description}", markup=False),
        *columns,
        console=Console(stderr=True),
        transient=True,
        auto_refresh=live,
        redirect_stdout=False,
        redirect_stderr=False,
    )


@contextmanager
def counted(noun: str) -> Iterator[Callable[[int, int, int], None]]:
    """Give a function `report(done, total, failed)` that draws a bar on a terminal, or a line per 100 in a pipe."""
    shown = _Counted(noun)
    try:
        yield shown
    finally:
        shown.end()


class _Counted:
    def __init__(self, noun: str) -> None:
        self.noun, self.terminal = noun, sys.stderr.isatty()
        self.start, self.first, self.drawn = time.monotonic(), -1, 0.0
        self.bar: Progress | None = None

    def __call__(self, done: int, total: int, failed: int) -> None:
        if self.first < 0:
            self.first = done - 1
        now = time.monotonic()
        if self.terminal and (now - self.drawn > _REDRAW or done == total):
            self.drawn = now
            self._draw(done, total, failed)
        elif not self.terminal and (done % _LINE_EVERY == 0 or done == total):
            sys.stderr.write(f"{self._line(done, total, failed)}\n")
            sys.stderr.flush()

    def end(self) -> None:
        if self.bar is not None:
            self.bar.stop()

    def _draw(self, done: int, total: int, failed: int) -> None:
        if self.bar is None:
            self.bar = _bar(live=False)  # worker processes are forked: no thread may hold a lock then
            self.bar.add_task("")
            self.bar.start()
        line = self._line(done, total, failed)
        self.bar.update(self.bar.task_ids[0], completed=done, total=total, description=line, refresh=True)

    def _line(self, done: int, total: int, failed: int) -> str:
        rate = (done - self.first) / max(time.monotonic() - self.start, 1e-9)
        left = _clock((total - done) / rate)
        return f"{done:,} of {total:,} {self.noun}, {failed:,} failed, {rate:.1f} per second, {left} left"


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
