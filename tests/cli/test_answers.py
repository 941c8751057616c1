"""Answers for scripts: what every JSON answer has, errors as objects, exit codes, standard input, public facts."""

from __future__ import annotations

import gzip
import io
import json
import shutil
import sys
from pathlib import Path

import pytest
from json_object import only_object
from refusals import assert_refused, snapshot

import meshmark as mm
from meshmark.cli.options import ModelFormat
from meshmark.errors import CapacityError, FormatError, InputError, KeyFileError, OutputError
from meshmark.io import FORMATS
from tests.keys import IDENTITY
from tests.shapes import pebble


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, files) -> Path:
    mm.write_mesh(mm.Mesh(*pebble(24)), tmp_path / "small.ply")
    shutil.copy(files.key, tmp_path / "my.key")
    (tmp_path / "marked.ply").write_bytes(files.marked.read_bytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def pipe(monkeypatch: pytest.MonkeyPatch):
    """Put bytes on standard input."""

    def put(content: bytes) -> None:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))

    return put


@pytest.mark.parametrize(
    ("line", "source", "outputs", "keyed"),
    [
        ("keygen new.key", None, {"key": "new.key"}, True),
        (
            "embed small.ply new.ply --key my.key --layers ownership --picture p.png",
            "small.ply",
            {"model": "new.ply", "picture": "p.png"},
            True,
        ),
        ("extract marked.ply --key my.key --report r.html", "marked.ply", {"report": "r.html"}, True),
        ("authenticate marked.ply --key my.key --map m.ply", "marked.ply", {"map": "m.ply"}, True),
        ("recover marked.ply out.ply --key my.key", "marked.ply", {"model": "out.ply"}, True),
        (
            "attack small.ply out.ply noise --map m.csv",
            "small.ply",
            {"model": "out.ply", "map": "m.csv"},
            False,
        ),
        ("attack --list", None, {}, False),
        (
            "compare small.ply small.ply --picture c.png",
            ["small.ply", "small.ply"],
            {"picture": "c.png"},
            False,
        ),
        ("saliency small.ply", "small.ply", {}, False),
        ("segment small.ply --picture s.png", "small.ply", {"picture": "s.png"}, False),
        ("info small.ply", "small.ply", {}, False),
    ],
)
def test_every_json_answer_names_version_input_outputs_and_key(cli, folder, line, source, outputs, keyed):
    ran = cli(*line.split(), "--json")
    told = only_object(ran.out)
    assert ran.code == 0, ran
    assert told["version"] == mm.__version__
    assert (told["input"], told["outputs"]) == (source, outputs)
    key = mm.Key.load("new.key" if "keygen" in line else "my.key")
    assert told["key"] == (key.fingerprint if keyed else None)
    assert [path for path in outputs.values() if not Path(path).is_file()] == []


def test_embed_names_them_too(files):
    assert files.printed["version"] == mm.__version__
    assert files.printed["input"] == str(files.model)
    assert files.printed["outputs"] == {"model": str(files.marked)}
    assert files.printed["key"] == mm.Key.load(files.key).fingerprint
    assert files.printed["side_files"] == []


def test_files_beside_a_model_are_named(cli, folder):
    told = only_object(cli("attack", "small.ply", "out.gltf", "noise", "--json").out)
    assert told["outputs"] == {"model": "out.gltf"}
    made = {str(path) for path in folder.iterdir()} - {
        str(folder / name) for name in ("small.ply", "my.key", "marked.ply", "out.gltf")
    }
    assert set(told["side_files"]) == made


@pytest.mark.parametrize(
    ("line", "kind", "file"),
    [
        ("info no.ply", "input", "no.ply"),
        ("info broken.off", "format", "broken.off"),
        ("extract small.ply --key no.key", "key_file", "no.key"),
        ("extract small.ply --key my.key --certificate small.ply", "input", "small.ply"),
        ("embed small.ply marked.ply --key my.key", "output", "marked.ply"),
        ("embed small.ply nowhere/out.ply --key my.key", "output", "nowhere/out.ply"),
        ("embed small.ply out.ply --key my.key --id 12", "input", None),
        ("embed small.ply out.ply", "usage", None),
        ("embed --what", "usage", None),
        ("nonsense", "usage", None),
    ],
)
def test_with_json_an_error_is_an_object_too(cli, folder, line, kind, file):
    (folder / "broken.off").write_text("OFF\n3 1 0\n0 0 0\n")
    before = snapshot(folder)
    ran = cli(*line.split(), "--json")
    assert_refused(ran, folder, before)
    error = json.loads(ran.out)["error"]
    assert (error["kind"], error["file"]) == (kind, file)


def test_a_model_that_cannot_carry_what_was_asked_has_an_exit_code_of_its_own(cli, folder):
    (folder / "one.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    before = snapshot(folder)
    for line in (
        "embed one.off out.off --key my.key",
        "embed small.ply out.ply --key my.key --layers both --payload marked.ply",
    ):
        ran = cli(*line.split(), "--json")
        assert_refused(ran, folder, before, codes=(4,))
        assert json.loads(ran.out)["error"]["kind"] == "capacity"
        assert json.loads(ran.out)["error"]["file"] == line.split()[1]


def test_kinds_of_errors_differ():
    kinds = [kind.kind for kind in (CapacityError, FormatError, InputError, KeyFileError, OutputError)]
    assert len(set(kinds)) == len(kinds)
    assert OutputError("x", file=Path("y")).file == "y"


def test_a_bare_meshmark_prints_its_help(cli):
    bare, asked = cli(), cli("--help")
    assert (bare.code, bare.err) == (0, "")
    assert bare.out == asked.out


def test_the_formats_of_standard_input_are_those_of_files():
    assert {entry.value for entry in ModelFormat} == FORMATS.keys()


@pytest.mark.parametrize("name", FORMATS)
def test_standard_input_is_read_as_the_file_would_be(cli, folder, pipe, name):
    mm.write_mesh(mm.Mesh(*pebble(24)), f"piped.{name}")
    content = Path(f"piped.{name}").read_bytes()
    told = only_object(cli("info", f"piped.{name}", "--json").out)
    for piped, packed in ((content, False), (gzip.compress(content), True)):
        pipe(piped)
        ran = cli("info", "-", "--format", name, "--json")
        assert (ran.code, ran.err) == (0, "")
        assert only_object(ran.out) == {**told, "input": "-", "gzipped": packed}


def test_a_mark_is_read_and_written_through_a_pipe(cli, folder, pipe, files):
    pipe(files.marked.read_bytes())
    ran = cli("extract", "-", "--format", "ply", "--key", "my.key")
    assert ran.out.startswith(f"Present: standard input carries the id {IDENTITY};")
    pipe(Path("small.ply").read_bytes())
    assert cli("attack", "-", "out", "none", "--format", "ply").code == 0
    assert Path("out").read_bytes() == Path("small.ply").read_bytes()
    pipe(Path("small.ply").read_bytes())
    assert cli("compare", "small.ply", "-", "--format", "ply").code == 0


def test_standard_input_without_a_format_or_a_format_without_it_is_refused(cli, folder, pipe):
    before = snapshot(folder)
    for line, words in (
        ("info -", "expected --format"),
        ("extract - --key my.key", "expected --format"),
        ("info small.ply --format ply", "--format ply is for standard input"),
        ("compare small.ply small.ply --format ply", "--format ply is for standard input"),
        ("compare - - --format ply", "only one of the two models"),
        ("info - --format off", "standard input"),
        ("info - --format xyz", "'xyz'"),
    ):
        pipe(Path("small.ply").read_bytes())
        ran = cli(*line.split())
        assert_refused(ran, folder, before)
        assert words in ran.err
    pipe(b"")
    assert "standard input is empty" in cli("info", "-", "--format", "ply").err


def test_info_of_a_key_says_that_it_is_one_and_never_shows_it(cli, folder):
    secret = Path("my.key").read_text().splitlines()[1]
    words, told = cli("info", "my.key"), cli("info", "my.key", "--json")
    assert words.out.startswith("kind         meshmark key file\n")
    assert only_object(told.out)["kind"] == "meshmark key file"
    assert only_object(told.out)["key"] == mm.Key.load("my.key").fingerprint
    for start in range(0, 64, 16):
        assert secret[start : start + 16] not in words.out + words.err + told.out + told.err
    Path("bad.key").write_text("meshmark key 1\nnone\n")
    assert cli("info", "bad.key").code == 2


def test_info_of_a_certificate_tells_what_is_public(cli, folder, files):
    line = "embed marked.ply again.ply --layers ownership --key my.key --certificate my.cert"
    identity = only_object(cli(*line.split(), "--json").out)["id"]
    ran = cli("info", "my.cert", "--json")
    told = only_object(ran.out)
    assert told["kind"] == "meshmark certificate"
    assert (told["certificate_version"], told["layers"], told["strength"]) == (4, "ownership", "standard")
    assert (told["vertices"], told["faces"]) == (files.vertices, files.faces)
    assert told["takes_mark_off"] is True
    assert len(told["model_digest"]) == 16
    assert identity not in ran.out
    assert told["model_digest"] == mm.Certificate.load("my.cert").summary()["model_digest"]
    cli(*line.replace("again.ply", "other.ply").replace("my.cert", "other.cert").split())  # another id
    assert told["model_digest"] != mm.Certificate.load("other.cert").summary()["model_digest"]
    assert f"{files.vertices:,}" in cli("info", "my.cert").out
    Path("old.cert").write_text(Path("my.cert").read_text().replace('"version": 4', '"version": 1', 1))
    assert "certificate of version 1" in cli("info", "old.cert").err
