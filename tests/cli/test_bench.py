"""`meshmark bench` from the outside: a scheme of another package, its tables, and bad usage."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from meshmark.io import write_mesh
from meshmark.research.benchmark.run.sample_shape import lopsided
from meshmark.research.benchmark.run.suites import SUITES, cases
from tests.counting import some
from tests.research.benchmark.runs import ended, install


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory):
    """A folder with an installed package that registers a scheme, and one with a model."""
    packages, models = (tmp_path_factory.mktemp(name) for name in ("packages", "models"))
    install(packages, ["Toy"])
    write_mesh(lopsided(36), models / "pebble.ply")
    return packages, models


def start(elsewhere, out, *more, seconds="0.1"):
    packages, models = elsewhere
    command = [sys.executable, "-m", "meshmark", "bench", "smoke", "--schemes", "toy", "--workers", "1"]
    return subprocess.Popen(
        [*command, "--data", models, "--out", out, *more],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(packages), "TOY_SECONDS": seconds},
        start_new_session=True,
    )


def test_a_scheme_in_one_file_outside_the_package_gets_every_table(elsewhere, tmp_path):
    process = start(elsewhere, tmp_path / "out", "--json")
    out, err = process.communicate(timeout=240)
    assert process.returncode == 0, err
    told = json.loads(out)
    expected_cases = list(cases("smoke", "toy", "pebble.ply", 0))
    expected = {(case.trial, case.attack) for case in expected_cases}
    assert {(line["trial"], line["attack"]) for line in told["summary"]} == expected
    assert told["facts"]["schemes"] == {"toy": "Toy (tests of meshmark)"}
    reports = {Path(path).name: Path(path).read_text(encoding="utf-8") for path in told["reports"]}
    assert reports.keys() >= {"results.csv", "report.md", "report.html"}
    assert all("toy" in text for text in some(reports.values()))
    clean = next(line for line in told["summary"] if (line["trial"], line["attack"]) == ("marked", "none"))
    assert (clean["recovered"], clean["ber"]) == (1, 0.0)
    assert f"{len(expected_cases)} of {len(expected_cases)} cases, 0 failed" in err


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal to a group")
def test_an_interrupted_run_says_what_is_kept_and_leaves_no_process(elsewhere, tmp_path):
    # A shell that runs tests in the background has all children ignore Ctrl-C, unless it is handled here.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    process = start(elsewhere, tmp_path, seconds="1")  # so slow that it is not done before it is interrupted
    while not list(tmp_path.glob("marked/*.npz")) and process.poll() is None:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert out == ""
    assert err == f"meshmark: what is done is kept in {tmp_path}; the same command goes on from there\n"
    assert ended(process.pid)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ["nonsense"],
            "'nonsense' is not a suite, expected one of smoke, paper, robust, ownership, security, speed",
        ),
        (["smoke", "--schemes", "nonsense"], "'nonsense' is not a scheme, expected one of ncdg_lv"),
        (["smoke", "--schemes", ","], "--schemes names no scheme"),
        (["smoke", "--data", "/nowhere"], "/nowhere is not a folder"),
        (["smoke", "--workers", "0"], "number of workers is 0"),
    ],
)
def test_bad_usage_is_one_sentence(cli, tmp_path, arguments, sentence):
    ran = cli("bench", *arguments, "--out", tmp_path / "out")
    assert ran.code == 2
    assert ran.out == ""
    assert sentence in ran.err
    assert ran.err.count("\n") == 1


def test_a_folder_that_cannot_be_made_is_an_error(cli, tmp_path):
    (tmp_path / "file").touch()
    ran = cli("bench", "smoke", "--out", tmp_path / "file" / "out")
    assert ran.code == 2
    assert "cannot make the folder" in ran.err


def test_the_help_names_every_suite(cli):
    ran = cli("bench", "--help")
    assert all(name in ran.out for name in some(SUITES))
