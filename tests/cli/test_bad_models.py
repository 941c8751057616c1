"""Bad models of every kind: one sentence, exit code 2, no traceback, no partial output, input untouched."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path

import numpy as np
import pytest
from refusals import assert_refused, snapshot

from tests.counting import some

pytestmark = pytest.mark.usefixtures("short_search")

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
# Commands that have an answer for a hollow model all the same.
ANSWERED = [
    *(
        ("a single triangle", name)
        for name in ("extract", "attack", "compare", "saliency", "segment", "info")
    ),
    ("all in one place", "attack"),
    *(("zero area", name) for name in ("attack", "compare", "saliency", "info")),
]
REFUSED = [
    (case, name)
    for case in HOLLOW
    for name in ("extract", "attack", "compare", "saliency", "segment", "info")
    if (case, name) not in ANSWERED
]


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
    assert_refused(ran, tmp_path, before, codes=(2, 4))
    assert name in ran.err, "the sentence names the file"


@pytest.mark.shared
def test_what_is_refused_of_hostile_files_is_named(cli, files, tmp_path, shared_data):
    """Small files only, for time."""
    suffixes = {".off", ".obj", ".ply", ".stl", ".glb", ".gltf", ".3mf", ".gz"}
    hostile = [
        path for path in sorted((shared_data / "hostile").rglob("*")) if path.suffix.lower() in suffixes
    ]
    refused = 0
    for number, path in enumerate(some(path for path in hostile if path.stat().st_size < 200)):
        ran = cli("recover" if number % 2 else "embed", path, tmp_path / "out.ply", "--key", files.key)
        assert ran.code in (1, 2, 4), ran
        assert path.name in (ran.out if ran.code == 1 else ran.err)
        refused += ran.code != 1
        assert not list(tmp_path.iterdir())
    assert refused > 60


@pytest.mark.parametrize(("case", "command"), REFUSED)
def test_hollow_models_are_refused(cli, files, tmp_path, case, command):
    name, content = HOLLOW[case]
    (tmp_path / name).write_bytes(content)
    before = snapshot(tmp_path)
    ran = cli(*commands(tmp_path / name, tmp_path, files.key)[command])
    assert_refused(ran, tmp_path, before)
    assert name in ran.err, "the sentence names the file"


@pytest.mark.parametrize(("case", "command"), ANSWERED)
def test_hollow_models_that_a_command_can_answer_carry_nothing(cli, files, tmp_path, case, command):
    name, content = HOLLOW[case]
    (tmp_path / name).write_bytes(content)
    ran = cli(*commands(tmp_path / name, tmp_path, files.key)[command])
    assert ran.code == (3 if command == "extract" else 0)  # nothing could carry: nothing can be told
    assert "present" not in ran.out.lower().split(":")[0].replace('"presence"', "")
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
    faces = start + 15 * files.vertices
    for place, value in (
        (start, np.float32("nan").tobytes()),
        (faces + 1, np.int32(files.vertices).tobytes()),
    ):
        (tmp_path / "bad.ply").write_bytes(whole[:place] + value + whole[place + 4 :])
        before = snapshot(tmp_path)
        ran = cli("embed", tmp_path / "bad.ply", tmp_path / "out.ply", "--key", files.key)
        assert_refused(ran, tmp_path, before)
