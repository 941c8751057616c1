"""A large surface with a few thousand faces, by the library fast-simplification."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import CapacityError
from meshmark.mesh import FloatArray, IntArray

__all__ = ["coarse_surface"]

# The library's first thresholds suit models of this size; see `attacks.simplification`.
SIZE = 2000.0
# Models of more points are simplified in a process of their own.
LARGE = 200_000
CHILD = Path(__file__).with_name("coarse_child.py")


def coarse_surface(points: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray]:
    """Return points and faces of a surface (p, 3), (m, 3) with about `target` faces, or fewer.

    Raises `CapacityError` where the library fails on a large model.
    """
    middle, size = points.mean(axis=0), float(np.ptp(points, axis=0).max()) / SIZE
    sized, corners32 = (points - middle) / size, faces.astype(np.int32)
    if len(points) > LARGE:
        moved, left = _in_a_child(sized, corners32, target)
    else:
        import fast_simplification

        moved, left = fast_simplification.simplify(sized, corners32, target_count=target)
    left = left.astype(np.int64)
    a, b, c = left.T
    left = left[(a != b) & (b != c) & (c != a)]
    used, corners = np.unique(left, return_inverse=True)
    return moved[used] * size + middle, corners.reshape(-1, 3)


def _in_a_child(points: FloatArray, faces: NDArray[np.int32], target: int) -> tuple[FloatArray, IntArray]:
    """Return what the library does, in a process of its own; raises `CapacityError` where that ends early.

    The library keeps all memory that it took for a model, half a kilobyte for each point.
    """
    with tempfile.TemporaryFile() as sent, tempfile.TemporaryFile() as received:
        for array in (points, faces, np.array(target)):
            np.save(sent, array)
        sent.seek(0)
        code = subprocess.run(
            [sys.executable, "-P", str(CHILD)],
            stdin=sent,
            stdout=received,
            stderr=subprocess.DEVNULL,
            check=False,
        ).returncode
        if code:
            raise CapacityError(
                f"a miniature of the model cannot be made: its simplification ended with {code}"
            )
        received.seek(0)
        return np.load(received), np.load(received)
