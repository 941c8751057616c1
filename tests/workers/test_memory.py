"""Peaks and limits of memory, each in a process of its own."""

from __future__ import annotations

import subprocess
import sys

import pytest

from meshmark.workers.memory import peak_mb

SIZE = 300 << 20


def said(code):
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True
    )
    return ran.stdout.split()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems keep the peak of the whole process")
def test_a_peak_can_be_forgotten():
    high, low, again = map(
        float,
        said(
            f"from meshmark.workers.memory import *\nb = b'x' * {SIZE}\nprint(peak_mb())\n"
            f"del b\nforget_peak()\nprint(peak_mb())\nb = b'x' * {SIZE}\nprint(peak_mb())"
        ),
    )
    assert 300 < high < 400
    assert low < 100
    assert 300 < again < 400


@pytest.mark.skipif(sys.platform == "win32", reason="there is no limit there")
def test_what_goes_beyond_the_limit_is_a_memory_error_and_the_process_lives():
    code = (
        "from meshmark.workers.memory import limit_memory\nlimit_memory(200)\n"
        f"try:\n    b'x' * {SIZE}\nexcept MemoryError:\n    print('refused')\nprint(len(b'x' * {SIZE // 10}))"
    )
    assert said(code) == ["refused", str(SIZE // 10)]


def test_this_process_has_a_peak():
    assert peak_mb() > 10
