"""`embed --bits`: ids of 32 bits, and marks without an id, in models too small for 64; what every command says."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

import numpy as np
import pytest
from folders import enter_copy
from json_object import only_object
from refusals import assert_refused, snapshot

import meshmark as mm
from meshmark.batch.batch_id import batch_id
from meshmark.batch.sources import Item
from meshmark.cli.batch_job import BatchCommand, done
from meshmark.coding.keys import Key
from meshmark.coding.message import bits_of, short_id
from tests.keys import IDENTITY, KEY, OTHER
from tests.low_poly import ball, box

pytestmark = pytest.mark.usefixtures("short_search")
EMBED = ("embed", "small.ply", "out.ply", "--key", "my.key", "--json")
SERIAL = "0000beef"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that tests copy: models of 26, 12 and 4 points, keys, a registry, and marked copies."""
    from meshmark.cli.main import main

    folder = tmp_path_factory.mktemp("made")
    mm.write_mesh(mm.Mesh(*box((2, 2, 2), (3.0, 2.0, 1.3))), folder / "small.ply")
    mm.write_mesh(mm.Mesh(*ball(0)), folder / "least.ply")
    corners = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.3]])
    mm.write_mesh(
        mm.Mesh(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])), folder / "four.ply"
    )
    KEY.save(folder / "my.key")
    OTHER.save(folder / "other.key")
    with contextlib.chdir(folder):
        key, registry = ["--key", "my.key"], ["--registry", "r.db"]
        assert main(["registry", "init", *registry]) == 0
        short = ["embed", "small.ply", "short.ply", "--bits", "32", "--id", SERIAL, "--to", "Ann"]
        with contextlib.redirect_stdout(io.StringIO()) as said:
            assert main([*short, "--certificate", "short.cert", *key, *registry, "--json"]) == 0
        Path("short.json").write_text(said.getvalue())
        none = ["embed", "least.ply", "none.ply", "--bits", "0", "--certificate", "none.cert"]
        assert main([*none, "--report", "none.html", *key]) == 0
    return folder


@pytest.fixture
def place(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the folder, which is the current one."""
    enter_copy(made, tmp_path, monkeypatch)
    monkeypatch.delenv("MESHMARK_REGISTRY", raising=False)
    return tmp_path


def turned(name: str) -> None:
    """Turn, scale and move a model's file, in another order of vertices."""
    mesh = mm.read_mesh(name)
    order = np.random.default_rng(4).permutation(len(mesh.vertices))
    back = np.argsort(order)
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    moved = 0.7 * mesh.vertices[order] @ turn.T + 3.0
    Path(name).unlink()
    mm.write_mesh(mm.Mesh(moved.astype(np.float32), back[mesh.faces]), name)


def test_an_id_of_32_bits_is_embedded_read_and_has_8_digits(cli, place):
    told = only_object(Path("short.json").read_text())
    assert (told["id"], told["bits"], told["layers"]) == (SERIAL, 32, "ownership")
    assert any("authentication layer is left out" in remark for remark in told["remarks"])
    turned("short.ply")
    found = only_object(cli("extract", "short.ply", "--key", "my.key", "--json").out)
    assert (found["presence"], found["id"], found["ids"], found["bits"]) == ("present", SERIAL, [SERIAL], 32)
    assert [each["id"] for each in found["evidence"]] == [SERIAL]
    assert f"carries the id {SERIAL};" in cli("extract", "short.ply", "--key", "my.key").out


def test_a_mark_without_an_id_is_present(cli, place):
    turned("none.ply")
    ran = cli("extract", "none.ply", "--key", "my.key", "--json")
    found = only_object(ran.out)
    assert (ran.code, found["presence"], found["id"], found["ids"], found["bits"]) == (
        0,
        "present",
        None,
        [],
        0,
    )
    assert [(each["layer"], each["id"]) for each in found["evidence"]] == [("points", None)]
    assert "carries a mark of this key, without an id" in cli("extract", "none.ply", "--key", "my.key").out


def test_no_mark_is_neither_present_nor_has_bits(cli, place):
    for name, key in (("none.ply", "other.key"), ("short.ply", "other.key"), ("least.ply", "my.key")):
        ran = cli("extract", name, "--key", key, "--json")
        found = only_object(ran.out)
        assert (ran.code, found["presence"], found["id"], found["bits"]) == (1, "absent", None, None)


def test_64_bits_are_the_default_and_their_refusal_says_what_fits(cli, place):
    before = snapshot(place)
    says = {
        ("small.ply", "64"): "88 are needed; --bits 32 fits, an id of 32 bits",
        ("least.ply", "32"): "56 are needed; --bits 0 fits, a mark without an id",
        ("four.ply", "0"): "its 4 points carry 10 bits of the code, 14 are needed",
    }
    for (name, bits), words in says.items():
        ran = cli("embed", name, "out.ply", "--key", "my.key", "--bits", bits)
        assert_refused(ran, place, before, (4,))
        assert words in ran.err


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--bits", "32", "--id", IDENTITY), "is one of 64 bits, expected 8 hexadecimal digits"),
        (("--id", SERIAL), "is one of 32 bits, expected 16 hexadecimal digits"),
        (("--bits", "0", "--id", SERIAL), "is one of 32 bits, expected none with 0 bits"),
        (("--bits", "32", "--layers", "both"), "signed with an id of 64 bits"),
        (("--bits", "0", "--layers", "authentication"), "signed with an id of 64 bits"),
        (("--bits", "32", "--tolerance", "web"), "signed with an id of 64 bits"),
        (("--bits", "32", "--payload", "miniature"), "signed with an id of 64 bits"),
        (("--bits", "0", "--registry", "r.db"), "a registry tells copies by their ids"),
    ],
)
def test_what_goes_with_other_bits_only_is_refused_by_name(cli, place, options, says):
    before = snapshot(place)
    ran = cli(*EMBED, *options)
    assert_refused(ran, place, before)
    assert says in ran.err


def test_a_registry_knows_ids_of_32_bits(cli, place):
    ran = cli("registry", "list", "--registry", "r.db", "--json")
    assert [(each["id"], each["recipient"]) for each in only_object(ran.out)["records"]] == [(SERIAL, "Ann")]
    shown = only_object(cli("registry", "show", SERIAL, "--registry", "r.db", "--json").out)
    assert [each["id"] for each in shown["records"]] == [SERIAL]
    assert cli("registry", "show", f"{SERIAL:0>16}", "--registry", "r.db", "--json").code == 1
    ran = cli(*EMBED, "--bits", "32", "--id", SERIAL, "--registry", "r.db")
    assert (ran.code, Path("out.ply").exists()) == (2, False)
    assert f"the id {SERIAL} is in the registry already" in ran.err
    traced = only_object(cli("trace", "short.ply", "--key", "my.key", "--registry", "r.db", "--json").out)
    matches = traced["matches"] if "matches" in traced else traced["suspects"][0]["matches"]
    assert [(each["recipient"], each["id"]) for each in matches] == [("Ann", SERIAL)]
    found = only_object(cli("extract", "short.ply", "--key", "my.key", "--registry", "r.db", "--json").out)
    assert (found["recipient"], found["id"]) == ("Ann", SERIAL)


def test_recipients_get_ids_of_32_bits_of_their_own(cli, place):
    (place / "to.csv").write_text("recipient\nBob\nCid\n")
    line = ("registry", "issue", "small.ply", "--to", "to.csv", "--out", "copies", "--key", "my.key")
    ran = cli(*line, "--registry", "r.db", "--bits", "0", "--json")
    assert (ran.code, Path("copies").exists()) == (2, False)
    assert "expected --bits 64 or 32" in ran.err
    ran = cli(*line, "--registry", "r.db", "--bits", "32", "--json")
    issued = only_object(ran.out)["issued"]
    assert (ran.code, [len(each["id"]) for each in issued]) == (0, [8, 8])
    assert len({each["id"] for each in issued}) == 2
    found = only_object(cli("extract", issued[1]["path"], "--key", "my.key", "--json").out)
    assert found["id"] == issued[1]["id"]


def test_a_batch_gives_every_model_an_id_of_32_bits_or_none(cli, place):
    secret = Key.load("my.key")
    assert bits_of(batch_id(secret, "a.ply", "00", 32)) == 32
    assert batch_id(secret, "a.ply", "00", 32) == short_id(batch_id(secret, "a.ply", "00") % 2**32)
    for bits, digits in (("32", 8), ("0", None)):
        command = BatchCommand(name="embed", key="my.key", out=f"out{bits}", options=("--bits", bits))
        name = "small.ply" if digits else "least.ply"
        row = done(command, Item(name=name, path=Path(name)))
        assert (row["exit_code"], row["bits"]) == (0, int(bits))
        assert row["id"] is None if digits is None else len(row["id"]) == digits


def test_certificates_belong_to_their_marks(cli, place):
    for name in ("short", "none"):
        line = ("--key", "my.key", "--certificate", f"{name}.cert", "--json")
        assert only_object(cli("authenticate", f"{name}.ply", *line).out)["verdict"] == "authentic"
        found = only_object(cli("extract", f"{name}.ply", *line).out)
        assert found["presence"] == "present"
        assert "certificate" not in found["advice"]
        assert cli("unmark", f"{name}.ply", f"{name}_plain.ply", *line).code == 0
    before, after = mm.read_mesh("least.ply").vertices, mm.read_mesh("none_plain.ply").vertices
    np.testing.assert_allclose(after, before, atol=1e-5)


@pytest.mark.parametrize(("name", "original"), [("short", "small.ply"), ("none", "least.ply")])
def test_a_moved_point_comes_back_from_the_original(cli, place, name, original):
    marked = mm.read_mesh(f"{name}.ply")
    vertices = marked.vertices.copy()
    vertices[3] += 0.001
    mm.write_mesh(marked.with_vertices(vertices), "moved.ply")
    line = ("--key", "my.key", "--certificate", f"{name}.cert", "--original", original, "--json")
    ran = cli("recover", "moved.ply", "back.ply", *line)
    assert (ran.code, only_object(ran.out)["restored_from"]) == (0, "marked_copy")
    np.testing.assert_allclose(mm.read_mesh("back.ply").vertices, marked.vertices, atol=1e-6)


@pytest.mark.parametrize(("name", "identity", "what"), [("short", SERIAL, "id"), ("none", None, "mark")])
def test_without_marks_of_authentication_nothing_is_said_of_changes(cli, place, name, identity, what):
    told = only_object(cli("authenticate", f"{name}.ply", "--key", "my.key", "--json").out)
    assert (told["verdict"], told["id"]) == ("inconclusive", identity)
    assert told["advice"].startswith(f"It carries the owner's {what}, but no mark of authentication")


def test_listed_ids_may_be_of_32_bits(cli, place):
    Path("ids.txt").write_text(f"{IDENTITY}\n{SERIAL}  # Ann\n")
    found = only_object(cli("extract", "short.ply", "--key", "my.key", "--among", "ids.txt", "--json").out)
    assert (found["id"], found["bits"]) == (SERIAL, 32)


def test_a_page_says_what_the_mark_carries(cli, place):
    assert "The model carries a mark without an id." in Path("none.html").read_text("utf-8")
    assert cli("extract", "none.ply", "--key", "my.key", "--report", "found.html").code == 0
    assert "It carries no id." in Path("found.html").read_text("utf-8")


def test_the_library_counts_ids_of_32_bits_apart(place):
    found = mm.extract(mm.read_mesh("short.ply"), KEY)
    assert (found.presence, found.id, found.bits) == ("present", short_id(int(SERIAL, 16)), 32)
    assert found.id != int(SERIAL, 16)
    none = mm.embed(mm.Mesh(*ball(0)), KEY, bits=0)
    assert (none.id, none.bits, none.to_dict()["id"]) == (None, 0, None)
    found = mm.extract(none.mesh, KEY)
    assert (found.presence, found.id, found.ids, found.bits) == ("present", None, (), 0)
