"""A coarse model in files of several formats: its id lies in points, and every command says the right thing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_commands import only_object

import meshmark as mm
from meshmark.coding.keys import Key
from meshmark.geometry.surface_of import surface_of
from meshmark.marking import Certificate
from meshmark.mesh import Mesh
from tests.low_poly import table

pytestmark = pytest.mark.usefixtures("short_search")

IDENTITY = "0123456789abcdef"
# What the format's numbers leave of the original, over the diagonal.
FORMATS = {"stl": 1e-6, "glb": 1e-6}


@pytest.fixture(scope="module")
def key(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("key") / "owner.key"
    Key(bytes(range(32))).save(path)
    return path


@pytest.mark.parametrize("form", FORMATS)
def test_a_coarse_model_is_marked_read_authenticated_and_unmarked(cli, key, tmp_path, form):
    model, marked, certificate = (tmp_path / name for name in (f"a.{form}", f"b.{form}", "b.cert"))
    mm.write_mesh(Mesh(*table()), model)
    before = model.read_bytes()
    ran = cli(
        "embed", model, marked, "--key", key, "--id", IDENTITY, "--layers", "ownership",
        "--certificate", certificate, "--json",
    )  # fmt: skip
    assert ran.code == 0
    printed = only_object(ran.out)
    assert (printed["id"], printed["layers"]) == (IDENTITY, "ownership")
    assert printed["carriers"] > 88
    assert model.read_bytes() == before != marked.read_bytes()
    assert Certificate.load(certificate).at_points

    ran = cli("extract", marked, "--key", key, "--json")
    found = only_object(ran.out)
    assert (ran.code, found["presence"], found["id"]) == (0, "present", IDENTITY)

    ran = cli("authenticate", marked, "--key", key, "--certificate", certificate, "--json")
    assert (ran.code, only_object(ran.out)["verdict"]) == (0, "authentic")
    ran = cli("authenticate", marked, "--key", key, "--json")
    assert only_object(ran.out)["verdict"] == "inconclusive"

    plain = tmp_path / f"c.{form}"
    ran = cli("unmark", marked, plain, "--key", key, "--certificate", certificate, "--json")
    assert ran.code == 0
    one, other = (surface_of(mm.read_mesh(path)) for path in (model, plain))
    assert len(one.points) == len(other.points) == len(table()[0])
    off = np.linalg.norm(other.points - one.points, axis=1).max() / one.diagonal
    assert off <= FORMATS[form]
    moved = np.linalg.norm(surface_of(mm.read_mesh(marked)).points - one.points, axis=1).max() / one.diagonal
    assert moved > 100.0 * off


def test_a_model_of_too_few_points_is_refused_in_one_sentence_with_their_number(cli, key, tmp_path):
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [0, 1.3, 0], [0, 0, 0.8]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    mm.write_mesh(Mesh(points, faces), tmp_path / "a.obj")
    ran = cli("embed", tmp_path / "a.obj", tmp_path / "b.obj", "--key", key, "--layers", "ownership")
    assert ran.code == 4
    assert "its 4 points carry" in ran.err
    assert "88 are needed" in ran.err
    assert len(ran.err.strip().splitlines()) == 1
    assert not (tmp_path / "b.obj").exists()
