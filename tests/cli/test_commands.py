"""The contract of the commands: fields, exit codes, and what goes to which stream."""

from __future__ import annotations

import json
import lzma
import re
import stat
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import meshmark as mm
from meshmark.coding.elapsed import SECONDS
from tests.counting import some
from tests.io.compressed_samples import draco_grid
from tests.shapes import pebble

IDENTITY = "0123456789abcdef"
EMBED = {
    "id", "layers", "vertices", "faces", "carriers", "mark_vertices", "payload_bytes", "rms_over_diagonal",
    "max_over_diagonal", "psnr_db", "seconds",
}  # fmt: skip
EXTRACT = {
    "presence", "id", "log10_false_positive", "mode", "advice", "seconds", "evidence",
}  # fmt: skip
COMPARE = {
    "rms_over_diagonal", "max_over_diagonal", "mrms_over_diagonal", "hausdorff_over_diagonal", "psnr_db",
    "paper_psnr_db", "msdm2", "normal_deviation_deg",
}  # fmt: skip


def only_object(text: str) -> dict[str, Any]:
    """Return the one JSON object that a text consists of; NaN and infinity are not JSON."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is not JSON")

    value = json.loads(text, parse_constant=refuse)
    assert isinstance(value, dict)
    return value


def test_keygen_makes_a_private_key_and_never_shows_it(cli, tmp_path):
    ran = cli("keygen", tmp_path / "a.key")
    secret = (tmp_path / "a.key").read_text()
    assert ran.code == 0
    assert stat.S_IMODE((tmp_path / "a.key").stat().st_mode) == 0o600
    assert not any(word in ran.out + ran.err for word in some(re.findall(r"[0-9a-f]{16,}", secret)))


def test_keygen_never_overwrites(cli, tmp_path):
    cli("keygen", tmp_path / "a.key")
    before = (tmp_path / "a.key").read_bytes()
    assert cli("keygen", tmp_path / "a.key").code == 2
    assert (tmp_path / "a.key").read_bytes() == before


def test_embed_gives_the_fields_of_the_contract(files):
    assert files.printed.keys() >= EMBED
    assert files.printed["id"] == IDENTITY
    assert files.printed["layers"] == "both"
    assert files.printed["mark_vertices"] > 0
    assert files.printed["payload_bytes"] > 0


def test_embed_stays_within_the_budget_as_an_independent_reading_of_the_files_says(files):
    before, after = mm.read_mesh(files.model).vertices, mm.read_mesh(files.marked).vertices
    moved = np.linalg.norm(after - before, axis=1)
    diagonal = np.linalg.norm(before.max(axis=0) - before.min(axis=0))
    assert 0 < np.sqrt((moved**2).mean()) / diagonal <= 8e-4
    assert files.printed["rms_over_diagonal"] == pytest.approx(
        np.sqrt((moved**2).mean()) / diagonal, rel=1e-6
    )
    assert files.printed["max_over_diagonal"] == pytest.approx(moved.max() / diagonal, rel=1e-6)


def test_embed_says_in_words_what_it_did_and_another_name_means_another_format(cli, files, tmp_path):
    arguments = ("--key", files.key, "--strength", "strong", "--layers", "ownership")
    ran = cli("embed", files.model, tmp_path / "m.stl", *arguments)
    assert ran.code == 0
    assert re.search(r"Marked: .*hare.ply.gz -> .*m.stl; id [0-9a-f]{16}; moved .* %", ran.out)
    assert "verified" in ran.out
    assert "colour" in ran.err, "what the target format cannot hold is said on standard error"
    assert "\n" not in ran.err.rstrip("\n")


def test_embed_draws_a_new_id_each_time(cli, files, small_model, tmp_path):
    arguments = ("--key", files.key, "--layers", "ownership", "--json")
    drawn = [cli("embed", small_model, tmp_path / f"{i}.ply", *arguments) for i in range(2)]
    assert len({only_object(ran.out)["id"] for ran in drawn}) == 2


def test_embed_without_an_extension_keeps_the_format(cli, files, small_model, tmp_path):
    arguments = ("--key", files.key, "--layers", "ownership")
    assert cli("embed", small_model, tmp_path / "model", *arguments).code == 0
    assert (tmp_path / "model").read_bytes().startswith(b"ply\n")


@pytest.mark.parametrize("name", ["out.fbx", "out.usdz", "out.dae", "out.blend"])
def test_no_command_writes_an_extension_that_is_not_a_format_of_ours(cli, files, tmp_path, name):
    out = tmp_path / name
    for line in (
        ("embed", files.model, out, "--key", files.key),
        ("attack", files.model, out, "noise"),
        ("recover", files.marked, out, "--key", files.key),
        ("unmark", files.marked, out, "--key", files.key, "--certificate", tmp_path / "none"),
    ):
        ran = cli(*line)
        assert (ran.code, ran.out) == (2, "")
        assert f"'{out.suffix}' is not the extension of a format that meshmark writes" in ran.err
    assert not out.exists()


def test_extract_reads_the_id_and_exits_with_0(cli, files):
    ran = cli("extract", files.marked, "--key", files.key, "--json")
    found = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    assert found.keys() >= EXTRACT
    assert (found["presence"], found["id"], found["mode"]) == ("present", IDENTITY, "blind")
    assert found["log10_false_positive"] == -30.0
    assert found["evidence"] == [{"layer": "cells", "id": IDENTITY, "log10_false_positive": -30.0}]
    assert IDENTITY in cli("extract", files.marked, "--key", files.key).out


@pytest.fixture
def shortened(monkeypatch):
    """Let a search try one spacing and one size of step of each way, so that a wide one ends soon."""
    from meshmark.ownership.search import restored, stretched

    spacings = restored.preferred_spacings
    monkeypatch.setattr(restored, "preferred_spacings", lambda area: spacings(area)[:1])
    for module in (restored, stretched):
        monkeypatch.setattr(module, "LOCK_STEPS", module.LOCK_STEPS[:1])


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


@pytest.mark.parametrize("search", ["quick", "wide"])
def test_extract_from_an_unmarked_model_exits_with_1(cli, files, shortened, search):
    ran = cli("extract", files.model, "--key", files.key, "--search", search, "--json")
    found = only_object(ran.out)
    assert (ran.code, found["presence"], found["id"]) == (1, "absent", None)


def test_extract_with_another_key_exits_with_1(cli, files, tmp_path):
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


def test_compare_gives_the_fields_of_the_contract(cli, files, small_model):
    ran = cli("compare", files.model, files.marked, "--json")
    fields = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    assert fields.keys() >= COMPARE
    assert fields["rms_over_diagonal"] == pytest.approx(files.printed["rms_over_diagonal"], rel=1e-6)
    assert fields["psnr_db"] == pytest.approx(files.printed["psnr_db"], abs=1e-4)
    assert None not in [fields[name] for name in COMPARE]
    words = cli("compare", small_model, small_model).out
    assert {line.split("  ")[0] for line in words.splitlines()} == {
        "vertices, RMS", "vertices, largest", "surfaces, RMS", "surfaces, largest", "PSNR", "PSNR, paper",
        "MSDM2, 0 to 1", "normals, degrees",
    }  # fmt: skip


def test_compare_of_equal_models_is_json_without_infinity(cli, files):
    fields = only_object(cli("compare", files.model, files.model, "--json").out)
    assert (fields["rms_over_diagonal"], fields["max_over_diagonal"], fields["psnr_db"]) == (0.0, 0.0, None)
    assert "infinite" in cli("compare", files.model, files.model).out


def test_compare_of_other_vertex_counts_says_null(cli, small_model, tmp_path):
    (tmp_path / "t.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    ran = cli("compare", small_model, tmp_path / "t.off", "--json")
    assert ran.code == 0
    fields = only_object(ran.out)
    assert {name for name in COMPARE if fields[name] is None} == {"rms_over_diagonal", "max_over_diagonal"}
    assert "1,106" in cli("compare", small_model, tmp_path / "t.off").out


def test_saliency_gives_the_fields_of_the_contract_and_a_picture(cli, files, tmp_path):
    ran = cli("saliency", files.model, "--picture", tmp_path / "s.png", "--json")
    fields = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    assert fields["vertices"] == 25178
    assert fields["seconds"] > 0
    assert all(
        0 <= point["vertex"] < 25178 and 0 <= point["beta"] <= 1 for point in some(fields["salient_points"])
    )
    assert _is_drawn(tmp_path / "s.png")
    assert "salient points" in cli("saliency", files.model).out


def test_segment_gives_the_fields_of_the_contract_and_a_picture(cli, files, tmp_path):
    ran = cli("segment", files.model, "--picture", tmp_path / "s.png", "--json")
    fields = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    assert fields["balance"] >= 1
    for colour in ("green_share", "blue_share"):
        assert sum(region[colour] for region in fields["regions"]) == pytest.approx(1, abs=1e-6)
    assert all({"id", "salient_vertex"} <= region.keys() for region in some(fields["regions"]))
    assert _is_drawn(tmp_path / "s.png")
    assert "balance" in cli("segment", files.model).out


def test_info_counts(cli, files):
    ran = cli("info", files.model, "--json")
    fields = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    expected = {
        "format": "ply",
        "vertices": 25178,
        "points": 25178,
        "faces": 50360,
        "parts": 1,
        "closed": True,
    }
    assert {name: fields[name] for name in expected} == expected
    assert "25,178" in cli("info", files.model).out


@pytest.mark.shared
def test_info_is_json_for_textured_models(cli, shared_data):
    paths = [path for path in sorted((shared_data / "textured").iterdir()) if path.stat().st_size < 3e6]
    for path in some((path for path in paths if path.suffix in {".glb", ".obj"}), least=3):
        ran = cli("info", path, "--json")
        assert ran.code == 0, ran.err
        only_object(ran.out)


@pytest.mark.shared
def test_info_is_json_for_models_of_all_shapes(cli, shared_data, tmp_path):
    packed = sorted((shared_data / "models" / "test").glob("*.off.xz"))
    for path in some((path for path in packed if path.stat().st_size < 100_000), least=5):
        plain = tmp_path / path.stem
        plain.write_bytes(lzma.decompress(path.read_bytes()))
        ran = cli("info", plain, "--json")
        assert ran.code == 0, ran.err
        assert only_object(ran.out)["faces"] > 0


def _is_drawn(path: Path) -> bool:
    with Image.open(path) as image:
        return image.format == "PNG" and len(set(image.convert("L").resize((64, 64)).tobytes())) > 10


def test_a_part_of_a_model_is_read_with_its_certificate(tmp_path, cli):
    model, marked, part, key, certificate = (
        str(tmp_path / name) for name in ("in.ply", "marked.ply", "part.ply", "my.key", "model.cert")
    )
    mm.write_mesh(mm.Mesh(*pebble(90)), model)
    cli("keygen", key)
    arguments = ("--id", IDENTITY, "--layers", "ownership", "--certificate", certificate)
    cli("embed", model, marked, "--key", key, *arguments)
    cli("attack", marked, part, "crop", "0.3", "--seed", "7")
    found = json.loads(cli("extract", part, "--key", key, "--certificate", certificate, "--json").out)
    assert (found["id"], found["mode"]) == (IDENTITY, "certificate")
    both = cli("extract", part, "--key", key, "--certificate", certificate, "--original", model)
    assert both.code == 2
    assert "exclude each other" in both.err


def test_the_certificate_needs_a_name_of_its_own(tmp_path, cli):
    model, marked, key = (str(tmp_path / name) for name in ("in.ply", "marked.ply", "my.key"))
    mm.write_mesh(mm.Mesh(*pebble(24)), model)
    cli("keygen", key)
    for name, words in (
        (marked, "expected different names"),
        (model, "is also an input"),
        (key, "is also an input"),
    ):
        refused = cli("embed", model, marked, "--key", key, "--certificate", name)
        assert refused.code == 2
        assert words in refused.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.ply", "my.key"]


def test_embed_reads_a_compressed_gltf_and_writes_it_plain_or_compressed_again(cli, files, tmp_path):
    source, plain, packed = (tmp_path / name for name in ("in.glb", "plain.glb", "packed.glb"))
    source.write_bytes(draco_grid(70, 16).glb())
    line = ("--key", files.key, "--id", IDENTITY, "--layers", "ownership", "--json")
    ran = cli("embed", source, plain, *line)
    assert ran.code == 0
    assert only_object(ran.out)["remarks"] == [
        "plain.glb is written without the compression of the input (KHR_draco_mesh_compression), all else is kept"
    ]
    ran = cli("embed", source, packed, *line, "--recompress")
    assert (ran.code, only_object(ran.out)["remarks"]) == (0, [])
    for path, names in ((plain, []), (packed, ["KHR_draco_mesh_compression"])):
        assert only_object(cli("info", path, "--json").out)["compression"] == names
        assert only_object(cli("extract", path, "--key", files.key, "--json").out)["id"] == IDENTITY
    assert only_object(cli("compare", source, packed, "--json").out)["hausdorff_over_diagonal"] < 0.01
    ran = cli("embed", files.model, tmp_path / "out.ply", *line, "--recompress")
    assert (ran.code, "is not compressed, expected no --recompress" in ran.err) == (2, True)
