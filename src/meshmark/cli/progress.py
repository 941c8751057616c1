"""A progress bar for long work: drawn on a terminal only, after a moment, and wiped when the work ends."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["progress"]

# Work shorter than this shows nothing; seconds.
_PATIENCE = 0.8
_REDRAW = 0.1
_WIDTH = 24
_BLOCK = 6


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
