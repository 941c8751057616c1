"""`extract`: fields, exit codes, and what goes to which stream."""

from __future__ import annotations

import pytest
from json_object import only_object

import meshmark as mm
from meshmark.coding.elapsed import SECONDS
from tests.keys import IDENTITY, KEY
from tests.shapes import pebble

EXTRACT = {
    "presence", "id", "log10_false_positive", "mode", "advice", "seconds", "evidence",
}  # fmt: skip

LAYERS = ("authentication", "cells")


def test_extract_reads_the_id_and_exits_with_0(cli, files):
    ran = cli("extract", files.marked, "--key", files.key, "--json")
    found = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    assert found.keys() >= EXTRACT
    assert (found["presence"], found["id"], found["mode"]) == ("present", IDENTITY, "blind")
    assert found["log10_false_positive"] == -30.0
    said = [{"layer": layer, "id": IDENTITY, "log10_false_positive": -30.0} for layer in LAYERS]
    assert [{name: entry[name] for name in said[0]} for entry in found["evidence"]] == said
    assert [entry["share"] > 0.95 for entry in found["evidence"]] == [True, True]
    assert IDENTITY in cli("extract", files.marked, "--key", files.key).out


def test_extract_among_listed_ids_names_the_one_that_is_there(cli, files, tmp_path):
    (tmp_path / "ids.txt").write_text(
        f"# issued\n\n{'0' * 16}\n  {IDENTITY.upper()}  # to Ann\n", encoding="utf-8"
    )
    found = only_object(
        cli("extract", files.marked, "--key", files.key, "--among", tmp_path / "ids.txt", "--json").out
    )
    assert (found["presence"], found["id"], found["ids"]) == ("present", IDENTITY, [IDENTITY])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            b"0000000000000000\n12\n",
            "ids.txt, line 2: the id '12' is not valid, expected 16 hexadecimal digits",
        ),
        (b"# none\n\n", "ids.txt lists no ids, expected one of 16 hexadecimal digits a line"),
        (b"\xff\xfe\x00", "ids.txt is no text, expected one id of 16 hexadecimal digits a line"),
        (None, "cannot read the ids in"),
    ],
)
def test_a_list_of_ids_that_cannot_be_used_is_refused_in_one_sentence(cli, files, tmp_path, content, message):
    if content is not None:
        (tmp_path / "ids.txt").write_bytes(content)
    ran = cli("extract", files.marked, "--key", files.key, "--among", tmp_path / "ids.txt")
    assert (ran.code, ran.out) == (2, "")
    assert message in ran.err
    assert ran.err.count("\n") == 1


def test_several_ids_are_all_named(cli, files, monkeypatch):
    from dataclasses import replace

    import meshmark.marking as scheme

    one = scheme.extract(mm.read_mesh(files.marked), mm.Key.load(files.key))
    several = replace(one, id=None, ids=(1, 2, 3), advice="An average.")
    monkeypatch.setattr(scheme, "extract", lambda *_, **__: several)
    ran = cli("extract", files.marked, "--key", files.key)
    assert ran.code == 0
    assert f"carries the ids {1:016x}, {2:016x} and {3:016x}; chance" in ran.out
    found = only_object(cli("extract", files.marked, "--key", files.key, "--json").out)
    assert (found["id"], found["ids"]) == (None, [f"{each:016x}" for each in (1, 2, 3)])


def test_extract_tells_numbers_that_help_to_remove_a_mark_only_to_who_diagnoses(cli, files):
    line = ("extract", files.marked, "--key", files.key)
    quiet, told = only_object(cli(*line, "--json").out), only_object(cli(*line, "--diagnose", "--json").out)
    more = {"carriers", "carriers_agreeing", "lock_score"}
    assert set(told) - set(quiet) == more
    assert set(quiet) <= set(told)
    assert quiet["seconds"] in SECONDS
    assert told["seconds"] not in SECONDS
    assert told["log10_false_positive"] < -30.0
    assert "below 10^-30." in cli(*line).out
    assert "below 10^-30." not in cli(*line, "--diagnose").out


def test_extract_from_an_unmarked_model_exits_with_1(cli, files, tmp_path, short_search):
    mm.write_mesh(mm.Mesh(*pebble(24)), tmp_path / "unmarked.ply")
    ran = cli("extract", tmp_path / "unmarked.ply", "--key", files.key, "--search", "wide", "--json")
    found = only_object(ran.out)
    assert (ran.code, found["presence"], found["id"]) == (1, "absent", None)


def test_extract_with_another_key_exits_with_1(cli, files, short_search, tmp_path):
    mm.Key(b"another key of thirty-two bytes!").save(tmp_path / "b.key")
    assert cli("extract", files.marked, "--key", tmp_path / "b.key").code == 1


def test_extract_that_cannot_tell_exits_with_3(cli, files, monkeypatch):
    from dataclasses import replace

    import meshmark.marking as scheme

    sure = scheme.extract(mm.read_mesh(files.marked), mm.Key.load(files.key))
    unsure = replace(sure, presence="inconclusive", id=None, ids=(), advice="The model is too small.")
    monkeypatch.setattr(scheme, "extract", lambda *_, **__: unsure)
    ran = cli("extract", files.model, "--key", files.key)
    assert ran.code == 3
    assert ran.out.startswith("Inconclusive")
    assert "too small" in ran.out


def test_a_part_of_a_model_is_read_with_its_certificate(tmp_path, cli, short_search):
    model, marked, part, key, certificate = (
        str(tmp_path / name) for name in ("in.ply", "marked.ply", "part.ply", "my.key", "model.cert")
    )
    mm.write_mesh(mm.Mesh(*pebble(90)), model)
    KEY.save(key)
    arguments = ("--id", IDENTITY, "--layers", "ownership", "--certificate", certificate)
    cli("embed", model, marked, "--key", key, *arguments)
    cli("attack", marked, part, "crop", "0.3", "--seed", "7")
    found = only_object(cli("extract", part, "--key", key, "--certificate", certificate, "--json").out)
    assert (found["id"], found["mode"]) == (IDENTITY, "certificate")
    both = cli("extract", part, "--key", key, "--certificate", certificate, "--original", model)
    assert both.code == 2
    assert "exclude each other" in both.err
