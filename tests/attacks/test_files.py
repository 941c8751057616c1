"""Round trips through files, against rounding done number by number."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest

from meshmark.attacks import ATTACKS
from meshmark.io import FORMATS
from meshmark.mesh import Mesh
from tests.attacks.models import seamed

MODEL = seamed(20)


def single(value: float) -> float:
    return float(np.float32(value))


# Written down again from what exporters do; not read from the module.
AS_WRITTEN = {
    "off": lambda value: float(format(value, ".6g")),
    "obj": lambda value: float(format(value, ".6f")),
    "3mf": lambda value: float(format(value, ".6f")),
    "ply": single,
    "stl": single,
    "glb": single,
    "gltf": single,
}


@pytest.mark.parametrize("name", FORMATS)
def test_positions_come_back_as_exporters_write_them(name):
    scaled = MODEL.with_vertices(MODEL.vertices * [1.0, 33.3, 1e-3])
    result = ATTACKS[f"file_{name}"].apply(scaled, 1, np.random.default_rng(1))
    expected = [[AS_WRITTEN[name](value) for value in row] for row in scaled.vertices.tolist()]
    np.testing.assert_array_equal(result.mesh.vertices, np.array(expected)[result.origin])
    np.testing.assert_array_equal(result.origin[result.mesh.faces], scaled.faces)
    corners = 3 * len(MODEL.faces) if name == "stl" else len(MODEL.vertices)
    assert len(result.mesh.vertices) == corners


@pytest.mark.parametrize("name", FORMATS)
def test_a_second_trip_changes_nothing(name):
    rng = np.random.default_rng(1)
    once = ATTACKS[f"file_{name}"](MODEL, 1, rng)
    twice = ATTACKS[f"file_{name}"](once, 1, rng)
    np.testing.assert_array_equal(once.vertices, twice.vertices)
    np.testing.assert_array_equal(once.faces, twice.faces)


@pytest.mark.parametrize("name", FORMATS)
def test_nothing_stays_on_the_disk(name, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    ATTACKS[f"file_{name}"](MODEL, 1, np.random.default_rng(1))
    assert list(Path(tmp_path).iterdir()) == []


def test_degenerate_faces_and_lone_vertices_travel_where_the_format_has_them():
    mesh = Mesh([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]], [[0, 1, 2], [0, 0, 1]])
    kept = {name: ATTACKS[f"file_{name}"](mesh, 1, np.random.default_rng(1)) for name in FORMATS}
    faces = {name: len(after.faces) for name, after in kept.items()}
    assert faces == {**dict.fromkeys(FORMATS, 2), "3mf": 1}, "3MF forbids a triangle that names a point twice"
    assert {name: len(after.vertices) for name, after in kept.items()} == {
        **dict.fromkeys(FORMATS, 4),
        "stl": 6,
    }
