"""`registry prove` and `registry verify`: what a third party is shown, and that no byte of it can be changed."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from json_object import only_object
from refusals import assert_refused, snapshot

import meshmark as mm
from tests.counting import some
from tests.keys import IDENTITY, KEY
from tests.shapes import pebble

pytestmark = pytest.mark.usefixtures("short_search")
PROJECT = KEY.derived("pebble")


@pytest.fixture(scope="module")
def proven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that tests copy: a registry with a copy of Ann's, and the proof that it is hers."""
    import contextlib

    from meshmark.cli.main import main

    folder = tmp_path_factory.mktemp("proven")
    mm.write_mesh(mm.Mesh(*pebble(40)), folder / "in.ply")
    PROJECT.save(folder / "project.key")
    with contextlib.chdir(folder):
        key = ["--key", "project.key", "--registry", "r.db"]
        assert main(["registry", "init", "--registry", "r.db"]) == 0
        assert (
            main(
                ["embed", "in.ply", "ann.ply", *key, "--to", "Ann", "--id", IDENTITY, "--layers", "ownership"]
            )
            == 0
        )
        assert main(["registry", "prove", IDENTITY, "--out", "proof", *key]) == 0
        Path("r.db").rename("hidden.db")
    return folder


@pytest.fixture
def place(proven: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(proven, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    return tmp_path / "copy"


def test_a_proof_is_confirmed_without_the_registry(cli, place):
    ran = cli("registry", "verify", "proof", "--key", "project.key", "--json")
    told = only_object(ran.out)
    assert (ran.code, told["confirmed"], told["why_not"]) == (0, True, None)
    assert (told["id"], told["recipient"]) == (IDENTITY, "Ann")
    assert told["log10_false_accusation"] < -6
    words = (place / "proof" / "proof.txt").read_text()
    assert f"It is made of the copy of Ann: id {IDENTITY}, a copy of in.ply." in words
    assert told["commitment"] in words


def test_the_script_of_a_proof_confirms_it(place):
    ran = subprocess.run(
        [sys.executable, "proof/verify.py", "project.key"],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert ran.returncode == 0, ran.stderr
    assert (
        "opened\nConfirmed: the suspect is made of the copy 0123456789abcdef, committed to for Ann"
        in ran.stdout
    )


def test_the_commitment_is_opened_by_hashing_alone(place):
    claim = json.loads((place / "proof" / "claim.json").read_text())
    statement = {"format": "meshmark commitment 1", **claim["statement"]}
    text = json.dumps(statement, sort_keys=True, separators=(",", ":")).encode()
    assert sha256(bytes.fromhex(claim["nonce"]) + text).hexdigest() == claim["commitment"]
    assert claim["statement"]["marked_digest"] == sha256((place / "ann.ply").read_bytes()).hexdigest()


def test_one_byte_changed_is_not_confirmed(cli, place):
    """In every file of the folder: at its begin, in its middle, and at its end."""
    files = [path for path in sorted((place / "proof").rglob("*")) if path.is_file()]
    for path in some(files, least=8):
        data = path.read_bytes()
        for at in (0, len(data) // 2, len(data) - 1):
            path.write_bytes(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :])
            ran = cli("registry", "verify", "proof", "--key", "project.key", "--json")
            assert (ran.code, only_object(ran.out)["confirmed"]) == (1, False), path.name
        path.write_bytes(data)


def test_a_file_more_or_less_or_another_key_is_not_confirmed(cli, place):
    line = ("registry", "verify", "proof", "--key")
    KEY.save("master.key")
    assert "made with another key" in cli(*line, "master.key").out
    (place / "proof" / "more.txt").write_text("more")
    assert cli(*line, "project.key").out == "Not confirmed: more.txt was added.\n"
    (place / "proof" / "more.txt").unlink()
    (place / "proof" / "suspect.png").unlink()
    assert cli(*line, "project.key").out == "Not confirmed: suspect.png is missing.\n"
    (place / "proof" / "seal.txt").unlink()
    assert cli(*line, "project.key").code == 1


def test_nothing_is_proven_of_a_model_that_does_not_carry_the_id(cli, place):
    Path("hidden.db").rename("r.db")
    mm.write_mesh(mm.Mesh(np.eye(4, 3), [[0, 1, 2], [0, 1, 3]]), "other.ply")
    before = snapshot(place)
    line = ("registry", "prove", IDENTITY, "--key", "project.key", "--registry", "r.db", "--out", "new")
    ran = cli(*line, "--suspect", "other.ply")
    assert (ran.code, ran.out) == (1, f"other.ply does not surely carry the id {IDENTITY}.\n")
    assert snapshot(place).keys() - {"r.db-wal", "r.db-shm"} == before.keys()


def test_what_cannot_be_proven_is_refused_in_one_sentence(cli, place):
    Path("hidden.db").rename("r.db")
    line = ("registry", "prove", IDENTITY, "--registry", "r.db")
    mm.Key(bytes(32)).save("other.key")
    for wrong, message in (
        (
            (*line, "--out", "proof", "--key", "project.key"),
            "proof exists already, expected a new or an empty folder",
        ),
        (
            (*line, "--out", "new", "--key", "other.key"),
            f"the registry has no copy with the id {IDENTITY} and this key",
        ),
        ((*line, "--out", "new", "--key", "project.key", "--suspect", "no.ply"), "no.ply"),
        (("registry", "verify", "nowhere", "--key", "project.key"), "nowhere holds no proof"),
    ):
        before = snapshot(place)
        ran = cli(*wrong)
        assert_refused(ran, place, before)
        assert message in ran.err


def test_a_row_that_was_edited_is_not_what_was_committed_to(cli, place):
    import sqlite3

    Path("hidden.db").rename("r.db")
    with sqlite3.connect("r.db") as connection:
        connection.execute("UPDATE copies SET recipient = 'Bob'")
    connection.close()
    line = ("registry", "prove", IDENTITY, "--key", "project.key", "--registry", "r.db", "--out", "new")
    ran = cli(*line, "--suspect", "ann.ply")
    assert ran.code == 2
    assert "was edited since the copy was made: it is not what was committed to" in ran.err
    assert not (place / "new").exists()
