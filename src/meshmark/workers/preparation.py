"""What a worker process does first: one thread for linear algebra, a limit on memory, an end with its parent."""

from __future__ import annotations

import os
import signal
import sys
import threading

from threadpoolctl import threadpool_limits

from meshmark.workers.memory import limit_memory

__all__ = ["prepare"]


def prepare(memory_mb: int) -> None:
    """Prepare this process to work for the one that started it; memory_mb: beyond it allocations fail, MiB.

    It ends when its parent does, however that happens. Ctrl-C is for the parent, which ends its workers.
    """
    threadpool_limits(1)
    limit_memory(memory_mb)
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with_parent()


def _end_with_parent() -> None:
    from multiprocessing import connection, parent_process

    parent = parent_process()
    if parent is None:
        return

    def watch() -> None:
        connection.wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    if sys.platform == "linux":  # the thread cannot run while foreign code holds the interpreter
        import ctypes

        set_death_signal = 1
        ctypes.CDLL(None).prctl(set_death_signal, signal.SIGKILL)
