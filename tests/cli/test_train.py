"""`meshmark train` from the outside, on two small models and two attacks."""

from __future__ import annotations

import json

import pytest

from meshmark.cli.main import main
from meshmark.io import write_mesh
from meshmark.mesh import Mesh
from meshmark.network.weights import parse_network
from meshmark.ownership.carrier_features import FEATURES
from meshmark.research.training import demodulator_trials as trials
from tests.research.training.test_training import TETRAHEDRON
from tests.shapes import pebble


@pytest.fixture
def folder(tmp_path):
    home = tmp_path / "models"
    home.mkdir()
    for name, stretch in (("long", 1.2), ("short", 1.0)):
        points, faces = pebble(52)
        write_mesh(Mesh(points * [stretch, 1.0, 1.0], faces), home / f"{name}.off")
    write_mesh(TETRAHEDRON, home / "tiny.off")
    return home


def test_train_writes_a_network_and_says_how_good_it_is(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(trials.trials, "__defaults__", ((("float32", 1.0), ("noise", 0.005)),))
    out = tmp_path / "network.json"
    command = ["train", "--data", str(folder), "--out", str(out), "--seed", "3", "--json"]
    assert main(command) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["models for validation"] == ["long.off"]
    assert told["models for fitting"] == ["short.off"]
    assert told["figures on validation models"]["float32:1"]["errors nearest point"] < 0.1
    assert parse_network(out.read_text(), FEATURES).sizes[0] == len(FEATURES)
    assert json.loads(out.read_text())["command"].endswith("--out network.json --seed 3 --most-points 20000")
    before = out.read_text()
    out.unlink()
    assert main(command) == 0
    assert out.read_text() == before


def test_train_refuses_what_it_cannot_use(tmp_path, capsys):
    out = tmp_path / "network.json"
    assert main(["train", "--data", str(tmp_path), "--out", str(out)]) == 2
    assert "there is no model below" in capsys.readouterr().err
    write_mesh(TETRAHEDRON, tmp_path / "tiny.off")
    assert main(["train", "--data", str(tmp_path), "--out", str(out)]) == 2
    assert "no model could be marked and read" in capsys.readouterr().err
    assert main(["train", "--data", str(tmp_path), "--out", str(tmp_path / "network.txt")]) == 2
    assert "expected .json" in capsys.readouterr().err
