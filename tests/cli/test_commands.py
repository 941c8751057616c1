"""The contract of `keygen` and `embed`: fields, exit codes, and what goes to which stream."""

from __future__ import annotations

import re
import stat

import numpy as np
import pytest
from json_object import only_object

import meshmark as mm
from tests.counting import some
from tests.io.compressed_samples import draco_grid
from tests.keys import IDENTITY, KEY
from tests.shapes import pebble

EMBED = {
    "id", "layers", "vertices", "faces", "carriers", "mark_vertices", "payload_bytes", "rms_over_diagonal",
    "max_over_diagonal", "psnr_db", "seconds",
}  # fmt: skip


def test_keygen_makes_a_private_key_and_never_shows_it(cli, tmp_path):
    ran = cli("keygen", tmp_path / "a.key")
    secret = (tmp_path / "a.key").read_text()
    assert ran.code == 0
    assert stat.S_IMODE((tmp_path / "a.key").stat().st_mode) == 0o600
    assert not any(word in ran.out + ran.err for word in some(re.findall(r"[0-9a-f]{16,}", secret)))


def test_keygen_derives_the_same_key_from_a_master_and_a_label(cli, tmp_path):
    KEY.save(tmp_path / "master.key")
    line = ("--from", tmp_path / "master.key", "--label")
    told = [
        only_object(cli("keygen", tmp_path / f"{number}.key", *line, label, "--json").out)
        for number, label in enumerate(("hare 2026", "hare 2026", "horse"))
    ]
    assert told[0]["key"] == told[1]["key"] != told[2]["key"]
    assert mm.Key.load(tmp_path / "0.key") == KEY.derived("hare 2026")
    assert stat.S_IMODE((tmp_path / "0.key").stat().st_mode) == 0o600
    for wrong, message in (
        (("--from", tmp_path / "master.key"), "--from and --label belong together"),
        (("--label", "hare"), "--from and --label belong together"),
        ((*line, ""), "a derived key needs a label"),
        (("--from", tmp_path / "no.key", "--label", "hare"), "cannot read the key file"),
    ):
        ran = cli("keygen", tmp_path / "new.key", *wrong)
        assert ran.code == 2
        assert message in ran.err
    assert not (tmp_path / "new.key").exists()


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
    assert re.search(r"Marked: .*pebble.ply.gz -> .*m.stl; id [0-9a-f]{16}; moved .* %", ran.out)
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
    source.write_bytes(draco_grid(50, 16).glb())
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
