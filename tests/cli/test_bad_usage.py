"""Bad keys, places, options and names: one sentence, exit code 2, no traceback, nothing written."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from refusals import assert_refused, snapshot


@pytest.mark.parametrize(
    "content", [b"", b"meshmark key 1\nabc\n", b"\xff" * 200, b"meshmark key 1\n" + b"G" * 64 + b"\n"]
)
def test_a_file_that_is_no_key(cli, files, tmp_path, content):
    (tmp_path / "bad.key").write_bytes(content)
    before = snapshot(tmp_path)
    for line in (("embed", files.model, tmp_path / "out.ply"), ("extract", files.marked)):
        assert_refused(cli(*line, "--key", tmp_path / "bad.key"), tmp_path, before)


def test_a_missing_key_and_a_folder_as_key(cli, files, tmp_path):
    before = snapshot(tmp_path)
    for key in (tmp_path / "no.key", tmp_path):
        assert_refused(cli("embed", files.model, tmp_path / "out.ply", "--key", key), tmp_path, before)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read and write everything")
def test_a_key_and_a_folder_without_permission(cli, files, tmp_path):
    closed = tmp_path / "closed"
    closed.mkdir()
    (tmp_path / "shut.key").write_bytes(files.key.read_bytes())
    (tmp_path / "shut.key").chmod(0)
    closed.chmod(0o500)
    assert cli("extract", files.marked, "--key", tmp_path / "shut.key").code == 2
    assert cli("embed", files.model, closed / "out.ply", "--key", files.key).code == 2
    assert not list(closed.iterdir())


def test_places_where_nothing_can_be_written(cli, files, tmp_path):
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder.ply").mkdir()
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "pebble.ply.gz").write_bytes(files.model.read_bytes())
    (tmp_path / "link.ply.gz").symlink_to(tmp_path / "pebble.ply.gz")
    shutil.copy(files.key, tmp_path / "own.key")
    before = snapshot(tmp_path)
    model, key = tmp_path / "pebble.ply.gz", tmp_path / "own.key"
    for out in (
        tmp_path,
        tmp_path / "folder.ply",
        tmp_path / "nowhere" / "out.ply",
        tmp_path / "file" / "out.ply",
        model,
        tmp_path / "folder.ply" / ".." / "pebble.ply.gz",
        tmp_path / "link.ply.gz",
        key,
        Path("/dev/full"),
        tmp_path / ("x" * 300 + ".ply"),
    ):
        assert_refused(cli("embed", model, out, "--key", key, "--layers", "ownership"), tmp_path, before)
        assert_refused(cli("attack", model, out, "noise", "--with", key), tmp_path, before)
    for out in (tmp_path / "folder.csv", tmp_path / "nowhere" / "a.csv", tmp_path / "a.ply", model):
        assert_refused(cli("attack", model, tmp_path / "out.ply", "noise", "--map", out), tmp_path, before)
    for command in ("saliency", "segment"):
        for out in (tmp_path / "folder.ply", tmp_path / "nowhere" / "a.png", tmp_path / "a.jpg", model):
            assert_refused(cli(command, model, "--picture", out), tmp_path, before)
    assert_refused(cli("keygen", tmp_path / "nowhere" / "a.key"), tmp_path, before)
    assert_refused(cli("keygen", tmp_path / "folder.ply"), tmp_path, before)
    assert_refused(cli("demo", "--out", tmp_path / "file"), tmp_path, before)


LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))
from meshmark.cli.main import run
run()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs resource limits")
def test_no_space_for_a_picture(small_model, tmp_path):
    """Of models and other outputs: test_outputs.py."""
    before = snapshot(tmp_path)
    line = ["segment", small_model, "--picture", tmp_path / "out.png"]
    ran = subprocess.run(
        [sys.executable, "-c", LIMITED, *map(str, line)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ran.returncode == 2, ran.stderr
    assert ran.stderr.startswith("meshmark: ")
    assert len(ran.stderr.splitlines()) == 1
    assert snapshot(tmp_path) == before


@pytest.mark.parametrize(
    "line",
    [
        ("nonsense",),
        ("embed",),
        ("embed", "a", "b"),
        ("extract", "a", "--key"),
        ("embed", "a", "b", "--key", "k", "--strength", "loud"),
        ("embed", "a", "b", "--key", "k", "--layers", "three"),
        ("embed", "a", "b", "--key", "k", "--tolerance", "none"),
        ("authenticate", "a"),
        ("authenticate", "a", "--key", "k", "--map", "m.obj"),
        ("authenticate", "a", "--key", "k", "--report", "m.pdf"),
        ("authenticate", "a", "--key", "k", "--map", "m.ply", "--payload", "m.ply"),
        ("authenticate", "a", "--key", "k", "--certificate", "c", "--original", "o"),
        ("recover", "a", "b"),
        ("unmark", "a", "b", "--key", "k"),
        ("extract", "a", "--key", "k", "--certificate", "c"),
        ("extract", "a", "--key", "k", "--search", "deep"),
        ("attack",),
        ("attack", "a", "b"),
        ("attack", "a", "b", "nonsense"),
        ("attack", "a", "b", "noise", "loud"),
        ("attack", "a", "b", "noise", "--", "-1"),
        ("attack", "a", "b", "noise", "nan"),
        ("attack", "a", "b", "crop:0.1+noise", "0.1"),
        ("attack", "a", "b", "crop:0.1", "0.1"),
        ("attack", "a", "b", "quantisation", "7.5"),
        ("attack", "a", "b", "collusion", "2"),
        ("attack", "a", "b", "noise+second_mark"),
        ("attack", "a", "b", "noise", "--seed", "-1"),
        ("attack", "a", "b", "noise", "--map", "m.txt"),
        ("info", "a", "b"),
        ("--what",),
    ],
)
def test_bad_usage_is_one_line(cli, tmp_path, line):
    assert_refused(cli(*line), tmp_path, {})
    assert_refused(cli(line[0], "--json", *line[1:]), tmp_path, {})


@pytest.mark.parametrize("identity", ["", "12", "0123456789abcdeg", "0x23456789abcdef", "0123456789abcdef0"])
def test_an_id_that_is_none(cli, files, tmp_path, identity):
    ran = cli("embed", files.model, tmp_path / "out.ply", "--key", files.key, "--id", identity)
    assert_refused(ran, tmp_path, {})


def test_odd_file_names_are_shown_without_harm(cli, tmp_path):
    ran = cli("info", tmp_path / "a\n\x1b[31m\udcff.ply")
    assert_refused(ran, tmp_path, {})
    assert "\x1b" not in ran.err


def test_a_key_that_others_can_read_needs_force(cli, files, tmp_path):
    shutil.copy(files.key, tmp_path / "open.key")
    (tmp_path / "open.key").chmod(0o644)
    before = snapshot(tmp_path)
    line = ("extract", files.marked, "--key", tmp_path / "open.key")
    ran = cli(*line)
    assert_refused(ran, tmp_path, before)
    assert "other users can read the key file" in ran.err
    assert cli(*line, "--force").code == 0
    assert cli("authenticate", *line[1:], "--force").code == 0
