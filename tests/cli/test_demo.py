"""`meshmark demo` does what it says, leaves its files, and never shows the key."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from refusals import assert_refused, snapshot

import meshmark as mm
from meshmark.cli.demo import NOISE, SCALE, travelled
from meshmark.cli.demo_damage import PUSH, bent
from meshmark.coding import message
from tests.shapes import pebble

pytestmark = pytest.mark.usefixtures("short_search")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("demo")


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Another model, smaller than the one that is included."""
    path = tmp_path_factory.mktemp("other") / "other.glb"
    mm.write_mesh(mm.Mesh(*pebble(56)), path)
    return path


def test_the_id_comes_back_from_the_changed_copy(cli, folder, monkeypatch):
    # Half a hare has cells enough for the id with about half of all keys and ids; these are one such pair.
    mm.Key(bytes(32)).save(folder / "demo.key")
    monkeypatch.setattr(message, "random_id", lambda bits: 1000)
    ran = cli("demo", "--out", folder)
    assert ran.code == 0, ran
    assert ran.err == ""
    names = {"demo.key", "original.ply", "marked.ply", "changed.glb", "demo.png"}
    names |= {"half.ply", "demo.cert", "edited.ply", "recovered.ply", "report.html"}
    assert {path.name for path in folder.iterdir()} == names
    secret = (folder / "demo.key").read_text().splitlines()[1]
    assert secret not in ran.out
    (identity,) = set(re.findall(r"\bid ([0-9a-f]{16})\b", ran.out))
    found = mm.extract(mm.read_mesh(folder / "changed.glb"), mm.Key.load(folder / "demo.key"))
    assert f"{found.id:016x}" == identity
    assert "in the half" in ran.out
    assert len(re.findall(r"present, id", ran.out)) == 2
    assert "with the key alone: altered" in ran.out
    before, after = map(float, re.search(r"was ([\d.]+) % .* now ([\d.]+) %", ran.out).groups())
    assert after < before / 4
    with Image.open(folder / "demo.png") as picture:
        assert picture.width == 4 * 640
        assert picture.height > 2 * 640


def test_another_model_and_a_second_time_in_the_same_folder(cli, folder, other, tmp_path):
    (tmp_path / "other.v2.glb").write_bytes(other.read_bytes())
    key = (folder / "demo.key").read_bytes()
    before = snapshot(folder)
    refused = cli("demo", tmp_path / "other.v2.glb", "--out", folder)
    assert_refused(refused, folder, before)
    assert "half.ply exists already" in refused.err
    ran = cli("demo", tmp_path / "other.v2.glb", "--out", folder, "--force")
    assert ran.code == 0, ran
    assert {"original.glb", "marked.glb", "changed.obj"} <= {path.name for path in folder.iterdir()}
    assert (folder / "demo.key").read_bytes() == key


def test_travelled_is_a_similarity_with_noise_of_the_stated_size_and_keeps_coincident_vertices():
    hare = np.random.default_rng(1).normal(size=(500, 3))
    mesh = mm.Mesh(np.concatenate([hare, hare[:100]]), [[0, 1, 2], [500, 3, 4]])
    moved = travelled(mesh).vertices
    assert np.array_equal(moved[:100], moved[500:])
    a, b = hare - hare.mean(axis=0), moved[:500] - moved[:500].mean(axis=0)
    u, sizes, v = np.linalg.svd(a.T @ b)
    assert np.linalg.det(u @ v) > 0
    assert sizes.sum() / np.square(a).sum() == pytest.approx(SCALE, rel=1e-3)
    rest = b - SCALE * a @ (u @ v)
    radius = np.linalg.norm(a, axis=1).mean()
    assert 0 < np.abs(rest).max() < 2 * SCALE * NOISE * radius
    assert np.array_equal(moved, travelled(mesh).vertices)


@pytest.mark.parametrize(("presence", "code"), [("absent", 1), ("inconclusive", 3), ("present", 1)])
def test_the_demo_fails_where_the_id_does_not_come_back(cli, folder, tmp_path, monkeypatch, presence, code):
    import meshmark.cli.demo as program
    import meshmark.marking as scheme
    import meshmark.report.demo_picture as drawing
    from meshmark.marking import marked_file

    monkeypatch.setattr(marked_file, "embed_file", partial(marked_file.embed_file, layers="ownership"))
    monkeypatch.setattr(drawing, "demo_picture", lambda *_: None)
    monkeypatch.setattr(program, "damage", lambda *_: [])
    true = scheme.extract(mm.read_mesh(folder / "changed.glb"), mm.Key.load(folder / "demo.key"))
    wrong = replace(true, presence=presence, id=1 if presence == "present" else None)
    monkeypatch.setattr(scheme, "extract", lambda *_, **__: wrong)
    mm.write_mesh(mm.Mesh(*pebble(30)), tmp_path / "small.glb")
    ran = cli("demo", tmp_path / "small.glb", "--out", folder, "--force")
    assert ran.code == code
    assert "did not come back" in ran.out


def test_bent_moves_the_top_only_and_keeps_coincident_vertices():
    random = np.random.default_rng(2)
    points = random.normal(size=(400, 3)) * [1.0, 3.0, 1.0]
    mesh = mm.Mesh(np.concatenate([points, points[:50]]), [[0, 1, 2]])
    shift = bent(mesh) - mesh.vertices
    assert np.array_equal(shift[:50], shift[400:])
    length = np.linalg.norm(shift, axis=1)
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    assert length.max() == pytest.approx(PUSH * diagonal)
    assert 0 < (length > 0).mean() < 0.3
