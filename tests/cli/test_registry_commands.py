"""`meshmark registry`, `embed --registry`, `extract --registry`: fields, exit codes, and what is left behind."""

from __future__ import annotations

import contextlib
import json
import shutil
import stat
import sys
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from folders import enter_copy
from json_object import only_object
from refusals import assert_refused, snapshot

import meshmark as mm
from meshmark.marking import marked_file
from meshmark.registry.registry import Registry
from tests.counting import some
from tests.keys import IDENTITY, KEY
from tests.registry.quick_embedding import embed_at_once
from tests.shapes import pebble

pytestmark = pytest.mark.usefixtures("short_search")
EMBED = ("embed", "in.ply", "--key", "my.key", "--layers", "ownership", "--registry", "issued.db")


ANN, BOB = "1" * 16, IDENTITY


@pytest.fixture(scope="module")
def issued(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that tests copy: a model, a key, a registry, Ann's copy, which is none, and Bob's."""
    from meshmark.cli.main import main

    folder = tmp_path_factory.mktemp("issued")
    mm.write_mesh(mm.Mesh(*pebble(40)), folder / "in.ply")
    KEY.save(folder / "my.key")
    with contextlib.chdir(folder):
        assert main(["registry", "init", "--registry", "issued.db"]) == 0
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(marked_file, "embed_file", embed_at_once)
            assert main([*EMBED, "ann.ply", "--to", "Ann", "--id", ANN]) == 0
        assert main([*EMBED, "bob.ply", "--to", "Bob", "--id", BOB]) == 0
    return folder


@pytest.fixture
def place(issued: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the folder, which is the current one."""
    enter_copy(issued, tmp_path, monkeypatch)
    monkeypatch.delenv("MESHMARK_REGISTRY", raising=False)
    return tmp_path


def records(cli, *options: object) -> list[dict]:
    return only_object(cli("registry", "list", "--registry", "issued.db", "--json", *options).out)["records"]


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(marked_file, "embed_file", embed_at_once)


def test_a_copy_is_entered_with_what_was_made_of_it(cli, place, issued, quick):
    told = only_object(cli(*EMBED, "carl.ply", "--to", "Carl", "--json").out)
    assert (told["recipient"], told["outputs"]) == ("Carl", {"model": "carl.ply"})
    first, second, third = records(cli)
    assert first.keys() >= {"id", "recipient", "original", "issued_at", "path"}
    assert (third["id"], third["recipient"], third["original"]) == (told["id"], "Carl", "in.ply")
    assert (second["id"], second["path"], second["state"]) == (BOB, str(issued / "bob.ply"), "issued")
    assert second["marked_digest"] == sha256((place / "bob.ply").read_bytes()).hexdigest()
    assert records(cli, "--to", "Bob") == [second]
    assert "Bob" in cli("registry", "show", BOB.upper(), "--registry", "issued.db").out


def test_a_leaked_copy_names_its_recipient(cli, place):
    ran = cli("extract", "bob.ply", "--key", "my.key", "--registry", "issued.db", "--json")
    found = only_object(ran.out)
    assert (ran.code, found["id"], found["recipient"], found["mode"]) == (0, BOB, "Bob", "registry")
    assert "issued to Bob" in cli("extract", "bob.ply", "--key", "my.key", "--registry", "issued.db").out


def test_a_variable_stands_in_for_the_option(cli, place, monkeypatch):
    monkeypatch.setenv("MESHMARK_REGISTRY", f"sqlite:///{place}/issued.db")
    assert only_object(cli("extract", "bob.ply", "--key", "my.key", "--json").out)["recipient"] == "Bob"
    assert "Ann" in cli("registry", "list").out


def test_an_id_that_is_not_in_the_registry_is_said_to_be_none_of_it(cli, place):
    assert cli("registry", "init", "--registry", "empty.db").code == 0
    ran = cli("extract", "bob.ply", "--key", "my.key", "--registry", "empty.db", "--json")
    found = only_object(ran.out)
    assert (ran.code, found["id"], found["recipient"]) == (0, BOB, None)
    assert "no copy with this id" in found["advice"]


def test_authenticate_names_the_recipient_and_looks_the_certificate_up(cli, place):
    line = ("authenticate", "bob.ply", "--key", "my.key")
    alone = only_object(cli(*line, "--json").out)
    assert (alone["recipient"], alone["verdict"], alone["certificate"]) == (None, "inconclusive", None)
    ran = cli(*line, "--registry", "issued.db", "--json")
    told = only_object(ran.out)
    assert (ran.code, told["recipient"], told["verdict"]) == (0, "Bob", "authentic")
    assert (told["mode"], told["certificate"]) == ("certificate", "own")
    assert "issued to Bob" in cli(*line, "--registry", "issued.db").out
    assert cli("registry", "init", "--registry", "empty.db").code == 0
    told = only_object(cli(*line, "--registry", "empty.db", "--json").out)
    assert (told["recipient"], told["mode"]) == (None, "blind")


def test_recover_takes_the_parts_from_the_file_of_the_copy(cli, place):
    mesh = mm.read_mesh("bob.ply")
    moved = mesh.vertices.copy()
    moved[40:60] *= 1.05
    mm.write_mesh(mesh.with_vertices(moved), "found.ply")
    shutil.copy("bob.ply", "kept.ply")
    line = ("recover", "found.ply", "back.ply", "--key", "my.key", "--registry", "issued.db", "--json")
    with Registry.open("issued.db") as registry:
        registry.relocate(int(BOB, 16), KEY.fingerprint, str(place / "gone.ply"))
    before = snapshot(place)
    ran = cli(*line)
    assert_refused(ran, place, before)
    assert "is no longer" in ran.err
    with Registry.open("issued.db") as registry:
        registry.relocate(int(BOB, 16), KEY.fingerprint, str(place / "kept.ply"))
    ran = cli(*line)
    told = only_object(ran.out)
    assert (ran.code, told["recovered"], told["restored_from"]) == (0, True, "marked_copy")
    assert np.abs(mm.read_mesh("back.ply").vertices - mesh.vertices).max() < 1e-6
    with Path("kept.ply").open("ab") as file:
        file.write(b" ")
    before = snapshot(place)
    ran = cli(*line[:2], "other.ply", *line[3:])
    assert_refused(ran, place, before)
    assert "was changed since it was marked" in ran.err


def test_recover_asks_no_registry_that_is_not_named(cli, place, monkeypatch):
    monkeypatch.setenv("MESHMARK_REGISTRY", "issued.db")
    told = only_object(cli("recover", "bob.ply", "back.ply", "--key", "my.key", "--json").out)
    assert (told["recovered"], told["restored_from"]) == (False, None)
    both = cli(
        "recover", "bob.ply", "x.ply", "--key", "my.key", "--registry", "issued.db", "--original", "in.ply"
    )
    assert both.code == 2
    assert "--original and --registry exclude each other" in both.err


def test_what_is_refused_leaves_no_row(cli, place):
    kept = records(cli)
    (place / "taken.ply").write_bytes(b"mine")
    mm.write_mesh(mm.Mesh(np.eye(4, 3), [[0, 1, 2], [0, 1, 3]]), "tiny.ply")
    models = {name: digest for name, digest in snapshot(place).items() if name.endswith(".ply")}
    tiny = ("embed", "tiny.ply", *EMBED[2:])
    for line, code, message in (
        ((*EMBED, "b.ply", "--to", "Carl", "--id", BOB), 2, "is in the registry already (issued to Bob"),
        ((*EMBED, "taken.ply", "--to", "Carl"), 2, "taken.ply exists already"),
        ((*EMBED, "in.ply", "--to", "Carl"), 2, "never overwritten"),
        ((*tiny, "b.ply", "--to", "Carl"), 4, "tiny.ply"),
    ):
        ran = cli(*line)
        assert (ran.code, ran.out) == (code, "")
        assert message in ran.err
        assert records(cli) == kept
    assert {name: digest for name, digest in snapshot(place).items() if name.endswith(".ply")} == models


def test_a_disk_that_fails_in_the_last_moment_leaves_no_row(cli, place, quick, monkeypatch):
    import os

    def link(*_: object, **__: object) -> None:
        raise FileExistsError(17, "File exists")

    monkeypatch.setattr(os, "link", link)
    ran = cli(*EMBED, "a.ply", "--to", "Ann")
    assert ran.code == 2
    monkeypatch.undo()
    with Registry.open(place / "issued.db") as registry:
        assert [copy.recipient for copy in registry.copies()] == ["Ann", "Bob"]
    assert not (place / "a.ply").exists()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("registry list", "no registry is named, expected --registry URL or the variable MESHMARK_REGISTRY"),
        ("registry list --registry none.db", "there is no registry at none.db, `meshmark registry init` makes one"),
        ("registry list --registry in.ply", "cannot read the registry in.ply: file is not a database"),
        ("registry init --registry in.ply", "cannot open the registry in.ply: file is not a database"),
        ("registry init --registry .", "cannot make the registry .: Is a directory"),
        ("registry list --registry postgresql://localhost:1/db?password=secret", "postgresql://localhost:1/db"),
        ("registry init --registry none/r.db", "cannot make the registry none/r.db: the folder none"),
        ("registry list --registry mysql://me:secret@host/db", "mysql://me:***@host/db is no place of a registry"),
        ("registry list --registry postgresql://me:secret@localhost:1/db", "postgresql://me:***@localhost:1/db"),
        ("registry list --registry postgresql://h:x/y", "the address of the registry cannot be read"),
        ("registry show 12 --registry issued.db", "the id '12' is not valid, expected 16 hexadecimal digits"),
        ("registry export out.txt --registry issued.db", "has the extension '.txt', expected .csv or .jsonl"),
        ("registry import none.csv --registry issued.db", "cannot read none.csv"),
        ("embed in.ply a.ply --key my.key --to Ann", "--to is kept in a registry, expected --registry as well"),
        ("embed in.ply a.ply --key my.key --registry no.db", "there is no registry at no.db"),
        ("extract in.ply --key my.key --registry no.db", "there is no registry at no.db"),
        ("registry nonsense", "nonsense"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused_in_one_sentence(cli, place, line, message):
    before = snapshot(place)
    ran = cli(*line.split())
    assert_refused(ran, place, before)
    assert message in ran.err
    assert "secret" not in ran.err
    assert_refused(cli(*line.split(), "--json"), place, before)


def test_without_its_libraries_a_registry_says_what_to_install(cli, place, monkeypatch):
    monkeypatch.setitem(sys.modules, "sqlalchemy", None)
    monkeypatch.delitem(sys.modules, "meshmark.registry.registry")
    ran = cli("registry", "list", "--registry", "issued.db")
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.endswith("get it with: pip install meshmark[registry]\n")


def test_a_new_registry_is_its_owners_alone(cli, place):
    assert cli("registry", "init", "--registry", "new.db").code == 0
    assert stat.S_IMODE((place / "new.db").stat().st_mode) == 0o600


def test_show_says_that_an_id_is_not_there(cli, place):
    ran = cli("registry", "show", "0" * 16, "--registry", "issued.db")
    assert (ran.code, ran.out) == (1, f"The registry has no copy with the id {'0' * 16}.\n")


@pytest.mark.parametrize("extension", ["csv", "jsonl"])
def test_an_export_is_imported_as_it_was(cli, place, extension):
    with Registry.open("issued.db") as registry:
        (original,) = registry.originals()
        for name in ('Ann, "the\nfirst"', "Zoë"):
            registry.reserve(original, KEY.fingerprint, recipient=name)
    out = f"out.{extension}"
    assert cli("registry", "export", out, "--registry", "issued.db").code == 0
    assert "exists already" in cli("registry", "export", out, "--registry", "issued.db").err
    assert cli("registry", "init", "--registry", "other.db").code == 0
    line = ("registry", "import", out, "--registry", "other.db", "--json")
    told = [only_object(cli(*line).out) for _ in range(2)]
    assert [(each["imported"], each["present"]) for each in told] == [(4, 0), (0, 4)]
    listed = only_object(cli("registry", "list", "--registry", "other.db", "--json").out)["records"]
    assert listed == records(cli)
    with Registry.open("issued.db") as one, Registry.open("other.db") as other:
        assert [each.descriptor is not None for each in one.originals()] == [True]
        whole = extension == "jsonl"
        assert (other.originals() == one.originals()) == whole
        for copy in some(one.copies()[:2], least=2):
            certificate = one.certificate(copy.id, copy.key)
            assert certificate is not None
            assert other.certificate(copy.id, copy.key) == (certificate if whole else None)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("in.csv", "id,key\n1,2\n", "the column 'original_digest' is missing, expected id, key, original_digest"),
        ("in.csv", f"id,key,original_digest\n12,{'0' * 16},{'0' * 64}\n", "line 2: the id '12' is not valid"),
        ("in.csv", f"id,key,original_digest\n{IDENTITY},x,{'0' * 64}\n", "line 2: 'key' is missing or not 16 hex"),
        ("in.jsonl", "{}\n", "line 1: expected an object with 'original' or 'copy'"),
        ("in.jsonl", "\n[1\n", "line 2: it is not JSON"),
        ("in.jsonl", '{"original": {"digest": "12"}}', "line 1: 'digest' is missing or not 64 hexadecimal digits"),
        ("in.jsonl", json.dumps({"copy": {"id": IDENTITY, "key": "0" * 16, "original_digest": "0" * 64}}),
         "line 1: its original is not in the lines before"),
    ],
)  # fmt: skip
def test_a_file_that_cannot_be_imported_changes_nothing(cli, place, name, content, message):
    (place / name).write_text(content)
    ran = cli("registry", "import", name, "--registry", "issued.db")
    assert (ran.code, ran.out) == (2, "")
    assert message in ran.err
    assert len(records(cli)) == 2


def test_an_import_of_an_id_that_is_taken_changes_nothing(cli, place):
    rows = [f"{'2' * 16},{KEY.fingerprint},{'0' * 64},Zoë", f"{IDENTITY},{KEY.fingerprint},{'0' * 64},Bob"]
    (place / "in.csv").write_text("\n".join(["id,key,original_digest,recipient", *rows]))
    ran = cli("registry", "import", "in.csv", "--registry", "issued.db")
    assert (ran.code, ran.out) == (2, "")
    assert f"the id {IDENTITY} is in the registry already as another copy" in ran.err
    assert len(records(cli)) == 2


def test_trace_names_the_recipient_of_each_suspect(cli, place):
    shutil.copy("bob.ply", "found.ply")
    line = ("trace", "bob.ply", "found.ply", "--key", "my.key", "--registry", "issued.db")
    ran = cli(*line)
    assert ran.code == 0
    assert (
        f"bob.ply is the copy of Bob: id {BOB}, made of in.ply, read with the key alone; chance of" in ran.out
    )
    assert "found.ply is the copy of Bob" in ran.out
    told = only_object(cli(*line, "--json").out)
    assert [each["suspect"] for each in told["traces"]] == ["bob.ply", "found.ply"]
    assert told["input"] == ["bob.ply", "found.ply"]


def test_trace_of_one_suspect_tells_of_it_at_the_top_as_well(cli, place):
    told = only_object(cli("trace", "bob.ply", "--key", "my.key", "--registry", "issued.db", "--json").out)
    assert told.keys() >= {"suspect", "matches", "seconds"}
    (match,) = told["matches"]
    assert match.keys() == {"recipient", "id", "original", "log10_false_accusation", "method", "share"}
    assert (match["recipient"], match["id"], match["original"]) == ("Bob", BOB, "in.ply")
    assert match["log10_false_accusation"] < -6


def test_trace_writes_a_page_of_one_suspect(cli, place):
    line = ("--key", "my.key", "--registry", "issued.db", "--report", "page.html")
    ran = cli("trace", "bob.ply", *line, "--json")
    told = only_object(ran.out)
    assert told["outputs"] == {"report": "page.html"}
    page = (place / "page.html").read_text(encoding="utf-8")
    assert f"<h1>The copy of {told['matches'][0]['recipient']}</h1>" in page
    assert told["matches"][0]["id"] in page
    ran = cli("trace", "bob.ply", "found.ply", *line, "--force")
    assert (ran.code, ran.out) == (2, "")
    assert "--report is of one suspect, but 2 are named, expected one" in ran.err


def test_trace_exits_with_1_where_a_suspect_names_nobody(cli, place):
    assert cli("registry", "init", "--registry", "empty.db").code == 0
    ran = cli("trace", "bob.ply", "--key", "my.key", "--registry", "empty.db")
    assert ran.code == 1
    assert ran.out.startswith("bob.ply names no recipient. The mark was read.")


def test_issue_makes_copies_in_several_processes(cli, place):
    (place / "people.csv").write_text("recipient\nCarl\nDora\n")
    mm.write_mesh(mm.Mesh(*pebble(32)), "small.ply")
    line = (
        "registry",
        "issue",
        "small.ply",
        "--to",
        "people.csv",
        "--out",
        "out",
        "--key",
        "my.key",
        "--json",
    )
    line = (
        *line,
        "--registry",
        "issued.db",
        "--layers",
        "authentication",
        "--payload",
        "none",
        "--workers",
        "2",
    )
    ran = cli(*line)
    told = only_object(ran.out)
    assert (ran.code, [each["recipient"] for each in told["issued"]]) == (0, ["Carl", "Dora"])
    assert [Path(each["path"]).name for each in told["issued"]] == ["carl.ply", "dora.ply"]
    listed = records(cli)
    assert {each["id"] for each in told["issued"]} == {each["id"] for each in listed[2:]}
    ran = cli(*line)
    assert ran.code == 2
    assert (
        "carl.ply is in the registry already, as a copy for Carl; expected another folder, or --resume"
        in ran.err
    )
    again = only_object(cli(*line, "--resume", "--workers", "1").out)
    assert again["issued"] == told["issued"]
