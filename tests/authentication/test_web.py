"""The tolerance `web`: grids of 14 bits as exports choose them are borne and named, edits beside them are seen."""

from __future__ import annotations

import json

import numpy as np
import pytest

from meshmark.attacks import ATTACKS
from meshmark.attacks.attack import Given
from meshmark.authentication.checks.coarse_digits import coarse_digits
from meshmark.authentication.marks.precision import precision_of
from meshmark.errors import CapacityError
from meshmark.io import read_mesh, write_mesh
from meshmark.marking import authenticate, embed, embed_file
from meshmark.marking.promises import ROUNDINGS
from meshmark.mesh import Mesh
from meshmark.metrics.tamper import iou
from tests.keys import ID, KEY
from tests.shapes import pebble

GRIDS = ("packed", "halves")


@pytest.fixture(scope="module")
def web():
    return embed(Mesh(*pebble(80)), KEY, id=ID, layers="authentication", tolerance="web")


def _on(grid: str, vertices):
    return ROUNDINGS[grid][0](vertices)


def test_the_mark_says_what_it_bears(web):
    assert web.to_dict()["tolerance"] == "web"
    assert web.payload_bytes > 0


def test_an_unchanged_model_is_authentic_and_not_called_requantised(web):
    found = authenticate(web.mesh, KEY)
    assert (found.verdict, found.id, found.requantised) == ("authentic", ID, None)


@pytest.mark.parametrize("grid", GRIDS)
def test_an_export_is_named_and_alters_nothing(web, grid):
    vertices = _on(grid, web.mesh.vertices)
    assert np.abs(vertices - web.mesh.vertices).max() > 0.4 * precision_of(web.mesh, "web")
    order = np.random.default_rng(4).permutation(len(vertices))
    shuffled = Mesh(vertices[order], np.argsort(order)[web.mesh.faces][::-1])
    found = authenticate(shuffled, KEY)
    assert (found.verdict, found.id) == ("authentic", ID)
    assert found.advice == "Requantised to 14 bits, otherwise as signed off."
    said = json.loads(json.dumps(found.to_dict()))
    assert (said["requantised"], said["requantised_bits"]) == (True, 14)


def test_a_grid_that_lies_elsewhere_is_borne_too(web):
    """Other meshes of a scene shift the grid; what it was is told from the coordinates alone."""
    rng = np.random.default_rng(8)
    step = np.ptp(web.mesh.vertices, axis=0).max() / (2**14 - 1)
    for _ in range(3):
        start = rng.uniform(0.0, step, 3)
        vertices = start + np.rint((web.mesh.vertices - start) / step) * step
        found = authenticate(Mesh(vertices, web.mesh.faces), KEY)
        assert (found.verdict, found.id) == ("authentic", ID)
        assert found.requantised is not None


@pytest.mark.parametrize(
    ("edit", "grid"), [("bump", "packed"), ("move_part", "halves"), ("replace_part", "packed")]
)
def test_an_edit_of_an_export_is_altered_and_found(web, grid, edit):
    exported = web.mesh.with_vertices(_on(grid, web.mesh.vertices))
    attacked = ATTACKS[edit].apply(exported, 0.02, np.random.default_rng(6), Given())
    step = np.ptp(exported.vertices, axis=0).max() / (2**14 - 1)
    start = exported.vertices.min(axis=0)
    vertices = start + np.rint((attacked.mesh.vertices - start) / step) * step
    found = authenticate(Mesh(vertices, attacked.mesh.faces), KEY)
    assert found.verdict == "altered"
    assert attacked.altered is not None
    assert iou(attacked.altered, found.altered) >= 0.75
    assert found.advice.startswith("Requantised")


def test_a_hole_in_an_export_is_seen_along_its_rim(web):
    exported = web.mesh.with_vertices(_on("packed", web.mesh.vertices))
    attacked = ATTACKS["delete_part"].apply(exported, 0.02, np.random.default_rng(6), Given())
    found = authenticate(attacked.mesh, KEY)
    assert found.verdict == "altered"
    assert attacked.altered is not None
    assert iou(attacked.altered, found.altered) >= 0.6


def test_points_removed_here_and_there_are_not_called_an_edit(web):
    """As `gltf-transform optimize` does: one end of an edge goes to the other, at eight places."""
    rng, faces = np.random.default_rng(2), web.mesh.faces.copy()
    vertices = _on("packed", web.mesh.vertices)
    for start, end, _ in web.mesh.faces[rng.choice(len(faces), 8, replace=False)]:
        faces[faces == start] = end
    whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    found = authenticate(Mesh(vertices, faces[whole]), KEY)
    assert (found.verdict, found.id) == ("inconclusive", ID)
    assert "simplified" in found.advice


def test_a_point_moved_by_itself_is_seen_in_the_file_as_written(web):
    vertices = web.mesh.vertices.copy()
    vertices[100] += 12.0 * precision_of(web.mesh, "web")
    assert authenticate(web.mesh.with_vertices(vertices), KEY).verdict == "altered"


@pytest.mark.parametrize("grid", GRIDS)
def test_coordinates_show_the_bits_of_both_grids(grid):
    vertices = 1.7 * pebble(30)[0] + 0.2
    found = coarse_digits(_on(grid, vertices))
    assert found is not None
    assert found.bits == 14


def test_a_glb_bears_web_exports_by_default_and_an_obj_does_not(tmp_path):
    mesh = Mesh(*pebble(60))
    used = {}
    for name, tolerance in (("a.glb", None), ("b.obj", None), ("c.gltf", "default")):
        made = embed_file(mesh, tmp_path / name, KEY, id=ID, payload="none", tolerance=tolerance)
        assert made.authentication is not None
        used[name] = made.authentication.tolerance
    assert used == {"a.glb": "web", "b.obj": "default", "c.gltf": "default"}


def test_a_glb_without_room_has_marks_of_the_default_and_says_so(tmp_path):
    made = embed_file(
        Mesh(*pebble(60)), tmp_path / "a.glb", KEY, id=ID, layers="authentication", strength="subtle"
    )
    assert made.authentication is not None
    assert made.authentication.tolerance == "default"
    assert any("14 bits" in remark for remark in made.remarks)


def test_a_tolerance_that_is_named_is_refused_without_room():
    with pytest.raises(CapacityError):
        embed(Mesh(*pebble(60)), KEY, id=ID, layers="authentication", strength="subtle", tolerance="web")


def test_no_mark_bears_11_bits_and_the_answer_says_which_rounding_it_was():
    made = embed(Mesh(*pebble(60)), KEY, id=ID, tolerance="web", payload="none")
    start, step = made.mesh.vertices.min(axis=0), np.ptp(made.mesh.vertices, axis=0).max() / (2**11 - 1)
    rounded = Mesh(start + np.rint((made.mesh.vertices - start) / step) * step, made.mesh.faces)
    for reference in (None, made.certificate):
        found = authenticate(rounded, KEY, reference=reference)
        assert (found.verdict, found.id) == ("inconclusive", ID)
        assert "a grid of 11 bits" in found.advice


def test_both_grids_are_written_as_their_tools_write_them(tmp_path):
    """What a GLB holds in 32-bit floats of either grid is read as that grid."""
    for grid in GRIDS:
        write_mesh(Mesh(_on(grid, pebble(30)[0]), pebble(30)[1]), tmp_path / f"{grid}.glb")
        found = coarse_digits(read_mesh(tmp_path / f"{grid}.glb").vertices)
        assert found is not None
        assert found.bits == 14
