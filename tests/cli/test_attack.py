"""`meshmark attack`: what it writes, what it says, and that it is the attack of the library."""

from __future__ import annotations

import gzip
import json
import re

import numpy as np
import pytest

import meshmark as mm
from meshmark.attacks import ATTACKS, parse_chain
from tests.counting import some

FIELDS = {
    "attack", "seed", "vertices", "vertices_before", "faces", "faces_before", "kept_vertices", "altered_vertices",
    "dropped", "seconds",
}  # fmt: skip


def attacked(path, chain: str, seed: int) -> mm.Mesh:
    return parse_chain(chain)(mm.read_mesh(path), np.random.default_rng(seed))


def test_the_list_names_every_attack_with_strengths_unit_and_what_it_imitates(cli):
    ran = cli("attack", "--list")
    assert (ran.code, ran.err) == (0, "")
    rows = re.findall(r"^(\w+) +(.+)\n +(.+)$", ran.out, re.MULTILINE)
    assert [name for name, _, _ in rows] == list(ATTACKS)
    for (name, strengths, imitates), entry in some(zip(rows, ATTACKS.values(), strict=True)):
        assert strengths.startswith(", ".join(f"{value:g}" for value in entry.strengths)), name
        assert entry.unit in strengths
        assert imitates.startswith(entry.imitates)
        assert ("needs" in imitates or "meshmark embed" in imitates) == bool(entry.needs)


def test_the_list_as_json_is_the_table(cli):
    listed = json.loads(cli("attack", "--list", "--json").out)["attacks"]
    assert [entry["name"] for entry in listed] == list(ATTACKS)
    for entry in some(listed):
        own = ATTACKS[entry["name"]]
        assert entry["strengths"] == list(own.strengths)
        assert (entry["default"], entry["unit"]) == (own.default, own.unit)
        assert (entry["imitates"], entry["needs"]) == (own.imitates, own.needs)


@pytest.mark.parametrize(
    ("arguments", "chain"),
    [
        (("noise", "0.005"), "noise:0.005"),
        (("noise",), "noise:0.005"),
        (("crop:0.1+noise:0.003+similarity",), "crop:0.1+noise:0.003+similarity:1"),
        (("bump", "0.05"), "bump:0.05"),
    ],
)
def test_out_holds_what_the_library_makes(cli, files, tmp_path, arguments, chain):
    before = files.model.read_bytes()
    ran = cli("attack", files.model, tmp_path / "out.ply", *arguments, "--seed", "5", "--json")
    fields = json.loads(ran.out)
    assert ran.code == 0
    assert fields.keys() >= FIELDS
    assert (fields["attack"], fields["seed"]) == (chain, 5)
    expected = attacked(files.model, chain, 5)
    found = mm.read_mesh(tmp_path / "out.ply")
    # Where the document stays, the file holds 32-bit floats.
    number = np.float64 if expected.document is None else np.float32
    np.testing.assert_array_equal(found.vertices, expected.vertices.astype(number))
    np.testing.assert_array_equal(found.faces, expected.faces)
    assert (fields["vertices"], fields["faces"]) == (len(found.vertices), len(found.faces))
    assert (fields["vertices_before"], fields["faces_before"]) == (files.vertices, files.faces)
    assert files.model.read_bytes() == before


def test_the_same_seed_gives_the_same_file_and_another_does_not(cli, files, tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        assert cli("attack", files.model, tmp_path / f"{name}.ply", "noise", "--seed", seed).code == 0
    content = [(tmp_path / f"{name}.ply").read_bytes() for name in "abc"]
    assert content[0] == content[1] != content[2]


@pytest.mark.parametrize("arguments", [("none",), ("noise", "0"), ("crop:0+shuffle:0",)])
def test_nothing_is_the_file_byte_by_byte(cli, files, tmp_path, arguments):
    assert cli("attack", files.model, tmp_path / "out.ply.gz", *arguments).code == 0
    assert (tmp_path / "out.ply.gz").read_bytes() == files.model.read_bytes()


def test_positions_are_patched_and_other_faces_lose_what_the_file_held_beside(cli, files, tmp_path):
    ran = cli("attack", files.model, tmp_path / "noisy.ply", "noise")
    assert (ran.code, ran.err) == (0, "")
    assert (tmp_path / "noisy.ply").stat().st_size == len(gzip.decompress(files.model.read_bytes()))
    ran = cli("attack", files.model, tmp_path / "cut.ply", "crop", "0.5")
    assert re.fullmatch(r"meshmark: cut.ply does not hold the model's vertex colours\n", ran.err)
    assert re.search(
        rf"-> .*cut.ply; crop:0.5, seed 0; [\d,]+ vertices \(before: {files.vertices:,}\)", ran.out
    )


@pytest.mark.parametrize("name", ["noise", "shuffle"])
def test_a_name_without_a_known_extension_keeps_the_format(cli, files, tmp_path, name):
    assert cli("attack", files.model, tmp_path / "out", name).code == 0
    assert mm.read_mesh(tmp_path / "out").document.format == "ply"
    assert cli("attack", files.marked, tmp_path / "out.obj", name).code == 0
    assert mm.read_mesh(tmp_path / "out.obj").document.format == "obj"


def test_the_map_tells_where_each_vertex_came_from(cli, files, tmp_path):
    line = (
        "attack",
        files.model,
        tmp_path / "out.ply",
        "delete_part:0.05+shuffle",
        "--map",
        tmp_path / "m.csv",
    )
    ran = cli(*line, "--json")
    head, *rows = (tmp_path / "m.csv").read_text().splitlines()
    assert head == "vertex,origin,altered"
    vertex, origin, altered = np.array([row.split(",") for row in rows], dtype=int).T
    np.testing.assert_array_equal(vertex, np.arange(len(rows)))
    after, before = mm.read_mesh(tmp_path / "out.ply"), mm.read_mesh(files.model)
    np.testing.assert_array_equal(after.vertices, before.vertices[origin])
    fields = json.loads(ran.out)
    assert fields["kept_vertices"] == len(rows) < files.vertices
    assert 0 < altered.sum() == fields["altered_vertices"]


def test_a_new_surface_has_a_map_without_origins(cli, files, tmp_path):
    line = ("attack", files.model, tmp_path / "out.ply", "voxels", "32", "--map", tmp_path / "m.csv")
    fields = json.loads(cli(*line, "--json").out)
    assert fields["kept_vertices"] is None
    rows = (tmp_path / "m.csv").read_text().splitlines()[1:]
    assert rows == [f"{vertex},-1,0" for vertex in range(fields["vertices"])]


def test_other_models_come_with_with(cli, files, tmp_path):
    other = tmp_path / "other.ply"
    assert cli("attack", files.model, other, "noise", "0.001").code == 0
    ran = cli("attack", files.model, tmp_path / "mean.ply", "collusion", "2", "--with", other)
    assert ran.code == 0
    mean = (mm.read_mesh(files.model).vertices + mm.read_mesh(other).vertices) / 2
    np.testing.assert_array_equal(mm.read_mesh(tmp_path / "mean.ply").vertices, mean.astype(np.float32))
    assert cli("attack", files.model, tmp_path / "p.ply", "paste", "0.1", "--with", other).code == 0
    few = cli("attack", files.model, tmp_path / "few.ply", "collusion", "3", "--with", other)
    assert few.code == 2
    assert "needs 2 other copies and was given 1" in few.err


def test_a_second_mark_is_made_by_embed(cli, files, tmp_path):
    ran = cli("attack", files.model, tmp_path / "out.ply", "second_mark")
    assert ran.code == 2
    assert "meshmark embed" in ran.err
