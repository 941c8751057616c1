"""The process in which gpytoolbox remeshes: arrays in on standard input, arrays out on standard output.

A program of its own rather than a forked worker: it starts clean whatever threads the caller holds, and needs no
guard in the caller's main file.
"""

from __future__ import annotations

import io
import sys

import numpy as np

PASSES = 10
"""Rounds of split, collapse, flip and smooth; the library's own number."""


def _main() -> None:
    """Read, remesh, write."""
    from gpytoolbox import remesh_botsch

    with np.load(io.BytesIO(sys.stdin.buffer.read())) as got:
        points, faces, edge, seconds = got["points"], got["faces"], float(got["edge"]), int(got["seconds"])
    _limit(seconds)
    points, faces = remesh_botsch(points, faces.astype(np.int32), PASSES, edge, True)
    np.savez(sys.stdout.buffer, points=points, faces=faces.astype(np.int64))


def _limit(seconds: int) -> None:
    """End this process by itself should its parent be gone when its time is up."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))


if __name__ == "__main__":
    _main()
