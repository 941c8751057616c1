"""Runs whose processes are killed: nothing is lost, nothing is done twice, nobody is left behind."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from meshmark.research.benchmark.run.marked_models import MARKED
from meshmark.research.benchmark.run.store import NAME
from tests.research.benchmark.runs import driver, ended, numbers, rows_in

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")


def start(models, out, outside, seconds):
    environment = {**os.environ, "PYTHONPATH": str(outside), "TOY_SECONDS": str(seconds)}
    command = driver("smoke", models, out)
    return subprocess.Popen(command, env=environment, start_new_session=True, stderr=subprocess.PIPE)


def test_a_killed_run_leaves_no_process_and_goes_on_where_it_was(models, outside, whole, tmp_path):
    chance = random.Random(7)
    before = []
    for _ in range(2):
        process = start(models, tmp_path, outside, 0.1)
        deadline, aim = time.monotonic() + 120, len(before) + chance.randint(1, 9)
        while time.monotonic() < deadline and process.poll() is None and count(tmp_path) < aim:
            time.sleep(0.01)
        time.sleep(chance.uniform(0, 0.1))
        process.kill()
        process.communicate()
        assert ended(process.pid), "a worker outlived the run"
        rows = rows_in(tmp_path)
        assert set(before) <= set(rows), "a finished case was repeated"
        assert len(rows) < len(whole.rows)
        before = rows
    assert before
    process = start(models, tmp_path, outside, 0)
    assert process.communicate()[1] == b""
    assert process.returncode == 0
    after = rows_in(tmp_path)
    assert set(before) <= set(after)
    assert numbers(after) == numbers(whole.rows)
    assert not list((tmp_path / MARKED).glob("*.tmp"))


def test_killed_workers_are_replaced_and_their_cases_done(models, outside, whole, tmp_path):
    process = start(models, tmp_path, outside, 0.05)
    killed = 0
    while killed < 3 and process.poll() is None:
        workers = workers_of(process.pid) if count(tmp_path) > 6 * killed else []
        for pid in workers[:1]:
            os.kill(pid, signal.SIGKILL)
            killed += 1
        time.sleep(0.02)
    assert process.communicate(timeout=300)[1] == b""
    assert killed == 3
    assert numbers(rows_in(tmp_path)) == numbers(whole.rows)


def count(out):
    """Return how many rows there are while another process writes them."""
    import sqlite3

    try:
        base = sqlite3.connect(f"file:{out / NAME}?mode=ro", uri=True, timeout=0.1)
    except sqlite3.Error:
        return 0
    try:
        return base.execute("SELECT count(*) FROM rows").fetchone()[0]
    except sqlite3.Error:
        return 0
    finally:
        base.close()


def workers_of(group):
    """Return the processes that judge cases: children of the server that the first process of the group started."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            pid, rest = path.read_text().split(" ", 1)
        except OSError:
            continue
        _, parent, own_group = rest.rpartition(")")[2].split()[:3]
        if int(own_group) == group and int(pid) != group and int(parent) != group:
            found.append(int(pid))
    return found
