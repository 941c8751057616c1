"""Speed and memory of a run."""

from __future__ import annotations

import subprocess
import sys

import pytest

from meshmark.errors import InputError
from meshmark.metrics.throughput import vertices_per_second


def test_vertices_per_second():
    assert vertices_per_second(3000, 1.5) == 2000.0
    for seconds in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="seconds"):
            vertices_per_second(1, seconds)


def test_peak_memory_counts_what_was_held_and_never_falls():
    # What counts is the most that a process ever held, and one that is started begins with what its parent did: a
    # shell in between holds little.
    script = "import numpy as np; from meshmark.metrics.throughput import peak_memory_mb as peak; before = peak(); "
    script += (
        "held = np.ones(int(before) * 2**17 + 2**24); after = peak(); size = held.nbytes / 2**20; del held; "
    )
    script += "print(size, after, peak())"
    shell = ["sh", "-c", '"$0" -c "$1"; exit', sys.executable, script]
    ran = subprocess.run(shell, capture_output=True, text=True, check=True)
    size, after, last = map(float, ran.stdout.split())
    assert after > size > 100
    assert last >= after
