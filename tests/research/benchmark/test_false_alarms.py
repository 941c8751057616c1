"""The benchmark of models that nobody altered: rows, resumption, and what it calls an alarm."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from claims import false_alarms
from meshmark.io import write_mesh
from meshmark.marking import embed
from meshmark.mesh import Mesh
from tests.keys import ID
from tests.shapes import pebble


@pytest.fixture
def data(tmp_path, monkeypatch):
    (tmp_path / "few").mkdir()
    write_mesh(Mesh(*pebble(36)), tmp_path / "few" / "stone.obj")
    monkeypatch.setattr(false_alarms, "DATA", tmp_path)
    return tmp_path


def _run(monkeypatch, data, *more):
    arguments = ["--store", str(data / "rows.csv"), "--models", "few", "--tolerances", "strict", *more]
    monkeypatch.setattr(sys, "argv", ["false_alarms", *arguments])
    return false_alarms.main()


def test_a_run_goes_on_where_another_stopped(data, monkeypatch, capsys):
    assert _run(monkeypatch, data, "--layers", "authentication") == 0
    first = false_alarms.read_rows(data / "rows.csv")
    assert [(row.model, row.layers, row.tolerance) for row in first] == [
        ("few/stone.obj", "authentication", "strict")
    ]
    assert (first[0].outcome, first[0].alarms, first[0].trials) == ("marked", 0, 17)
    assert _run(monkeypatch, data, "--layers", "authentication", "ownership", "--written") == 0
    rows = false_alarms.read_rows(data / "rows.csv")
    assert rows[:1] == first
    assert [(row.layers, row.trials) for row in rows] == [("authentication", 17), ("ownership", 1)]
    assert "2 rows wanted, 1 to make" in capsys.readouterr().out


def test_what_was_altered_is_an_alarm_and_counted():
    marked = embed(Mesh(*pebble(36)), false_alarms.KEY, id=ID, layers="authentication", payload="none")
    assert not false_alarms.raises_alarm(marked.mesh, ID, "authentication")
    assert false_alarms.raises_alarm(marked.mesh, ID + 1, "authentication")
    vertices = marked.mesh.vertices.copy()
    vertices[:20] += 0.01 * np.random.default_rng(1).normal(size=(20, 3))
    assert false_alarms.raises_alarm(Mesh(vertices, marked.mesh.faces), ID, "authentication")
    row = false_alarms.Row(
        model="a",
        layers="both",
        tolerance="strict",
        points=9,
        outcome="marked",
        trials=17,
        alarms=0,
        alarmed="",
        said="",
        seconds=1.0,
    )
    table = false_alarms.table([row, replace(row, model="b", alarms=2, alarmed="float32 to-stl")])
    assert "| both | strict | 2 | 0 | 0 | 34 | 2 |" in table
    assert "alarms after float32: 1" in table
