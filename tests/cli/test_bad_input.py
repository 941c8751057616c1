"""Bad input of every kind: one sentence, exit code 2, no traceback, no partial output, input untouched."""

from __future__ import annotations

import gzip
import hashlib
import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

UNREADABLE = {
    "a PDF called PLY": ("a.ply", b"%PDF-1.7\n1 0 obj\n<< /Type /Catalog >>\nendobj\n"),
    "an unknown format": ("a.docx", b"PK\x05\x06" + bytes(18)),
    "an empty file": ("a.obj", b""),
    "an empty PLY": ("a.ply", b""),
    "broken gzip": ("a.ply.gz", b"\x1f\x8b\x08\x00garbage"),
    "text instead of numbers, OFF": ("a.off", b"OFF\n3 1 0\n0 0 zero\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "text instead of numbers, OBJ": ("a.obj", b"v 0 0 zero\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    "text instead of a count": ("a.off", b"OFF\nthree 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "NaN, OFF": ("a.off", b"OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "infinity, OBJ": ("a.obj", b"v 0 0 inf\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    "index out of range, OFF": ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
    "index out of range, OBJ": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
    "negative index": ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
    "truncated OFF": ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n"),
    "truncated GLB": ("a.glb", b"glTF" + struct.pack("<II", 2, 1000)),
    "counts beyond the file": ("a.off", b"OFF\n999999999999 1 0\n0 0 0\n"),
}
HOLLOW = {
    "no vertices": ("a.off", b"OFF\n0 0 0\n"),
    "no faces": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
    "a single triangle": ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "all in one place": ("a.obj", b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"),
    "zero area": ("a.obj", b"v 0 0 0\nv 1 1 1\nv 2 2 2\nv 3 3 3\nf 1 2 3\nf 2 3 4\n"),
}


def snapshot(folder: Path) -> dict[str, str]:
    """Return the names of all files below a folder, hidden ones too, and digests of what they hold."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        if path.is_file()
        else "folder"
        for path in folder.rglob("*")
    }


def assert_refused(ran, folder: Path, before: dict[str, str]) -> None:
    """One sentence on standard error, exit code 2, and nothing changed."""
    assert ran.code == 2, ran
    assert ran.out == ""
    lines = ran.err.splitlines()
    assert len(lines) == 1, ran.err
    assert lines[0].startswith("meshmark: ")
    assert len(lines[0]) > 25
    assert "Traceback" not in ran.err
    assert "bug in meshmark" not in ran.err
    assert snapshot(folder) == before


def commands(path: Path, folder: Path, key: Path):
    """Return every command line that reads a model, on `path`."""
    return {
        "embed": ("embed", path, folder / "out.ply", "--key", key),
        "embed json": ("embed", path, folder / "out.obj", "--key", key, "--json"),
        "extract": ("extract", path, "--key", key),
        "attack": ("attack", path, folder / "out.ply", "noise", "0.01", "--map", folder / "out.csv"),
        "compare": ("compare", path, path),
        "saliency": ("saliency", path, "--picture", folder / "out.png"),
        "segment": ("segment", path, "--picture", folder / "out.png", "--json"),
        "info": ("info", path, "--json"),
        "demo": ("demo", path, "--out", folder.parent / "demo"),
    }


@pytest.mark.parametrize(
    "command", ["embed", "embed json", "extract", "attack", "compare", "saliency", "segment", "info"]
)
@pytest.mark.parametrize("case", UNREADABLE)
def test_unreadable_models(cli, files, tmp_path, case, command):
    name, content = UNREADABLE[case]
    (tmp_path / name).write_bytes(content)
    before = snapshot(tmp_path)
    ran = cli(*commands(tmp_path / name, tmp_path, files.key)[command])
    assert_refused(ran, tmp_path, before)
    assert name in ran.err, "the sentence names the file"


@pytest.mark.parametrize(
    "command", ["embed", "embed json", "extract", "attack", "compare", "saliency", "segment", "info"]
)
def test_a_missing_model_and_a_folder(cli, files, tmp_path, command):
    before = snapshot(tmp_path)
    assert_refused(cli(*commands(tmp_path / "no.ply", tmp_path, files.key)[command]), tmp_path, before)
    assert_refused(cli(*commands(tmp_path, tmp_path, files.key)[command]), tmp_path, before)


@pytest.mark.parametrize("case", HOLLOW)
def test_models_that_cannot_carry_a_mark(cli, files, tmp_path, case):
    name, content = HOLLOW[case]
    (tmp_path / name).write_bytes(content)
    before = snapshot(tmp_path)
    ran = cli("embed", tmp_path / name, tmp_path / "out.obj", "--key", files.key)
    assert_refused(ran, tmp_path, before)
    assert name in ran.err, "the sentence names the file"


@pytest.mark.shared
def test_what_is_refused_of_hostile_files_is_named(cli, files, tmp_path, shared_data):
    """Small files only, for time."""
    suffixes = {".off", ".obj", ".ply", ".stl", ".glb", ".gltf", ".3mf", ".gz"}
    hostile = [
        path for path in sorted((shared_data / "hostile").rglob("*")) if path.suffix.lower() in suffixes
    ]
    refused = 0
    for path in (path for path in hostile if path.stat().st_size < 200):
        for line in (("embed", path, tmp_path / "out.ply"), ("recover", path, tmp_path / "out.ply")):
            ran = cli(*line, "--key", files.key)
            assert ran.code in (1, 2), ran
            assert path.name in (ran.err if ran.code == 2 else ran.out)
            refused += ran.code == 2
        assert not list(tmp_path.iterdir())
    assert refused > 60


@pytest.mark.parametrize("command", ["extract", "attack", "compare", "saliency", "segment", "info"])
@pytest.mark.parametrize("case", HOLLOW)
def test_hollow_models_never_crash_a_command(cli, files, tmp_path, case, command):
    name, content = HOLLOW[case]
    (tmp_path / name).write_bytes(content)
    before = snapshot(tmp_path)
    ran = cli(*commands(tmp_path / name, tmp_path, files.key)[command])
    if ran.code == 2:
        assert_refused(ran, tmp_path, before)
        assert name in ran.err, "the sentence names the file"
    else:
        assert "present" not in ran.out.lower().split(":")[0]
        assert ran.err == ""


def test_a_model_cut_off_anywhere(cli, files, tmp_path):
    whole = gzip.decompress(files.model.read_bytes())
    for share in (0.0005, 0.3, 0.999):
        (tmp_path / "cut.ply").write_bytes(whole[: int(share * len(whole))])
        before = snapshot(tmp_path)
        ran = cli("embed", tmp_path / "cut.ply", tmp_path / "out.ply", "--key", files.key)
        assert_refused(ran, tmp_path, before)
    (tmp_path / "cut.ply.gz").write_bytes(files.model.read_bytes()[:-5000])
    before = snapshot(tmp_path)
    assert_refused(
        cli("embed", tmp_path / "cut.ply.gz", tmp_path / "out.ply", "--key", files.key), tmp_path, before
    )


def test_a_binary_model_with_nan_or_an_index_out_of_range(cli, files, tmp_path):
    whole = gzip.decompress(files.model.read_bytes())
    start = whole.index(b"end_header\n") + len(b"end_header\n")
    faces = start + 15 * 25178
    for place, value in ((start, np.float32("nan").tobytes()), (faces + 1, np.int32(25178).tobytes())):
        (tmp_path / "bad.ply").write_bytes(whole[:place] + value + whole[place + 4 :])
        before = snapshot(tmp_path)
        ran = cli("embed", tmp_path / "bad.ply", tmp_path / "out.ply", "--key", files.key)
        assert_refused(ran, tmp_path, before)


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
    (tmp_path / "hare.ply.gz").write_bytes(files.model.read_bytes())
    (tmp_path / "link.ply.gz").symlink_to(tmp_path / "hare.ply.gz")
    (tmp_path / "own.key").write_bytes(files.key.read_bytes())
    before = snapshot(tmp_path)
    model, key = tmp_path / "hare.ply.gz", tmp_path / "own.key"
    for out in (
        tmp_path,
        tmp_path / "folder.ply",
        tmp_path / "nowhere" / "out.ply",
        tmp_path / "file" / "out.ply",
        model,
        tmp_path / "folder.ply" / ".." / "hare.ply.gz",
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
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
from meshmark.cli.main import run
run()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs resource limits")
@pytest.mark.parametrize("command", ["embed", "segment"])
def test_no_space_for_the_output(files, tmp_path, command):
    before = snapshot(tmp_path)
    line = {
        "embed": ["embed", files.model, tmp_path / "out.ply", "--key", files.key, "--layers", "ownership"],
        "segment": ["segment", files.model, "--picture", tmp_path / "out.png"],
    }[command]
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
        (),
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


@pytest.mark.parametrize("identity", ["", "12", "0123456789abcdeg", "0x23456789abcdef", "0123456789abcdef0"])
def test_an_id_that_is_none(cli, files, tmp_path, identity):
    ran = cli("embed", files.model, tmp_path / "out.ply", "--key", files.key, "--id", identity)
    assert_refused(ran, tmp_path, {})


def test_odd_file_names_are_shown_without_harm(cli, tmp_path):
    ran = cli("info", tmp_path / "a\n\x1b[31m\udcff.ply")
    assert_refused(ran, tmp_path, {})
    assert "\x1b" not in ran.err
