"""A progress bar for long work: drawn on a terminal only, after a moment, and wiped when the work ends."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["counted", "progress"]

# Work shorter than this shows nothing; seconds.
_PATIENCE = 0.8
_REDRAW = 0.1
_WIDTH = 24
_BLOCK = 6
# Without a terminal, a line after so many cases.
_LINE_EVERY = 100


@contextmanager
def progress(label: str) -> Iterator[None]:
    """Show that `label` is going on, and for how long, while the block runs.

    The length of a search or a solve is not known beforehand, so a block travels along the bar.
    """
    if not sys.stderr.isatty():
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
    start = time.monotonic()
    if done.wait(_PATIENCE):
        return
    while not done.wait(_REDRAW):
        seconds = time.monotonic() - start
        sys.stderr.write(f"\r{_bar(seconds)} {label}, {seconds:.0f} s ")
        sys.stderr.flush()
    sys.stderr.write("\r\x1b[K")
    sys.stderr.flush()


def _bar(seconds: float) -> str:
    free = _WIDTH - _BLOCK
    turn = int(seconds / _REDRAW) % (2 * free)
    left = turn if turn <= free else 2 * free - turn
    return "[" + " " * left + "=" * _BLOCK + " " * (free - left) + "]"


@contextmanager
def counted(noun: str) -> Iterator[Callable[[int, int, int], None]]:
    """Give a function `told(done, total, failed)` that draws a bar on a terminal, or a line per 100 in a pipe."""
    shown = _Counted(noun)
    try:
        yield shown
    finally:
        shown.end()


class _Counted:
    def __init__(self, noun: str) -> None:
        self.noun, self.terminal = noun, sys.stderr.isatty()
        self.start, self.first, self.drawn = time.monotonic(), -1, 0.0

    def __call__(self, done: int, total: int, failed: int) -> None:
        if self.first < 0:
            self.first = done - 1
        now = time.monotonic()
        if self.terminal and (now - self.drawn > _REDRAW or done == total):
            self.drawn = now
            sys.stderr.write(f"\r{self._line(done, total, failed)}\x1b[K")
        elif not self.terminal and (done % _LINE_EVERY == 0 or done == total):
            sys.stderr.write(f"{self._line(done, total, failed)}\n")
        sys.stderr.flush()

    def end(self) -> None:
        if self.terminal and self.drawn:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def _line(self, done: int, total: int, failed: int) -> str:
        rate = (done - self.first) / max(time.monotonic() - self.start, 1e-9)
        filled = _WIDTH * done // total
        bar = "[" + "=" * filled + " " * (_WIDTH - filled) + "] " if self.terminal else ""
        left = _clock((total - done) / rate)
        return (
            f"{bar}{done:,} of {total:,} {self.noun}, {failed:,} failed, {rate:.1f} per second, {left} left"
        )


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
