"""Speed and memory of a run."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.metrics.throughput import peak_memory_mb, vertices_per_second


def test_vertices_per_second():
    assert vertices_per_second(3000, 1.5) == 2000.0
    for seconds in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="seconds"):
            vertices_per_second(1, seconds)


def test_peak_memory_counts_what_was_held_and_never_falls():
    before = peak_memory_mb()
    held = np.ones(int(before) * 2**17 + 2**24)  # as much again as ever, and 128 MiB
    after = peak_memory_mb()
    assert after > held.nbytes / 2**20 > 100
    del held
    assert peak_memory_mb() >= after
