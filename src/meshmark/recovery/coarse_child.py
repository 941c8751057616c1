"""The process in which fast-simplification works on a large model: arrays on standard input and output.

A program of its own rather than a forked worker: it starts clean whatever threads the caller holds, and needs no
guard in the caller's main file.
"""

from __future__ import annotations

import sys

import numpy as np


def _main() -> None:
    """Read points, faces and how many faces are wanted; simplify; write points and faces."""
    import fast_simplification

    points, faces, target = (np.load(sys.stdin.buffer) for _ in range(3))
    for array in fast_simplification.simplify(points, faces, target_count=int(target)):
        np.save(sys.stdout.buffer, array)


if __name__ == "__main__":
    _main()
