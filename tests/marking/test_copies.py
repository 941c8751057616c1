"""Scenes that show one mesh several times: marked as one, and read from any of the copies."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.payload.payload import Payload, pack, unpack
from meshmark.authentication.payload.signed_totals import Whole
from meshmark.io import read_mesh, write_mesh
from meshmark.marking import authenticate, authentication_layer, embed, extract, recover, unmark
from meshmark.marking.marked_file import embed_file
from meshmark.mesh import Mesh
from tests.copies_samples import baked, glb, placed, threemf
from tests.keys import ID, KEY, OTHER
from tests.shapes import pebble

SHAPE, LARGE = pebble(36), pebble(50)
COUNT = len(LARGE[0])
SMALL = pebble(20)
PLANE = (
    np.array([[-9, -9, -2], [9, -9, -2], [9, 9, -2], [-9, 9, -2.0]]),
    np.array([[0, 1, 2], [0, 2, 3]]),
)
SCENES = {
    "two": ([SHAPE], [(0, placed((0, 0, 0), 1)), (0, placed((3, 0, 0), 2))]),
    "sizes": (
        [SHAPE],
        [(0, placed((0, 0, 0), 1, 0.4)), (0, placed((3, 0, 0), 2)), (0, placed((6, 0, 0), 3, 0.7, True))],
    ),
    "stretched": ([SHAPE], [(0, np.eye(4)), (0, placed((4, 0, 0), 2) @ np.diag([1.0, 1.4, 0.8, 1.0]))]),
    "beside others": (
        [SHAPE, SMALL],
        [(1, placed((0, 4, 0), 5)), (0, placed((0, 0, 0), 1)), (0, placed((3, 0, 0), 2, 0.8))],
    ),
    "two kinds": (
        [SHAPE, SMALL],
        [(1, placed((i, 4, 0), i)) for i in (0, 4)] + [(0, placed((i, 0, 0), i)) for i in (1, 5)],
    ),
}


@pytest.fixture(scope="module")
def marked(tmp_path_factory):
    """Return a marked file with two copies, and the file that it was made from."""
    folder = tmp_path_factory.mktemp("copies")
    glb(folder / "in.glb", [LARGE], SCENES["two"][1])
    result = embed_file(folder / "in.glb", folder / "out.glb", KEY, id=ID, layers="both")
    return folder, result


@pytest.mark.parametrize("name", SCENES)
def test_copies_are_marked_as_one_and_read_from_the_file_and_from_what_bakes_them(name, tmp_path):
    glb(tmp_path / "in.glb", *SCENES[name])
    result = embed_file(tmp_path / "in.glb", tmp_path / "out.glb", KEY, id=ID, layers="both")
    written = read_mesh(tmp_path / "out.glb")
    formats = {"two": ("obj", "stl"), "sizes": ("obj",), "stretched": ("obj",)}.get(name, ())
    for mesh in (written, *(baked(written, tmp_path / f"out.{suffix}") for suffix in formats)):
        found = extract(mesh, KEY, search="plain")
        assert (found.presence, found.id) == ("present", ID)
        assert found.log10_false_positive < -12
        verdict = authenticate(mesh, KEY)
        assert (verdict.verdict, verdict.id, verdict.points_missing) == ("authentic", ID, 0)
    assert result.rms_over_diagonal <= 8e-4


def test_two_items_and_a_component_of_a_3mf_are_copies(tmp_path):
    matrices = [placed((10 * i, 0, 0), i, 3.0 + i) for i in range(3)]
    threemf(tmp_path / "in.3mf", SHAPE, matrices)
    embed_file(tmp_path / "in.3mf", tmp_path / "out.3mf", KEY, id=ID, layers="both")
    written = read_mesh(tmp_path / "out.3mf")
    for mesh in (written, baked(written, tmp_path / "out.ply")):
        assert extract(mesh, KEY, search="plain").id == ID
        assert authenticate(mesh, KEY).verdict == "authentic"


def test_another_key_finds_nothing_in_copies(marked):
    assert extract(read_mesh(marked[0] / "out.glb"), OTHER, search="plain").id is None


def test_every_showing_is_an_image_of_the_marked_mesh(marked):
    folder, result = marked
    mesh = read_mesh(folder / "out.glb")
    np.testing.assert_array_equal(mesh.vertices, result.mesh.vertices)
    first, second = (placed((0, 0, 0), 1), placed((3, 0, 0), 2))
    stored = [
        (mesh.vertices[rows] - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T
        for rows, matrix in ((slice(0, COUNT), first), (slice(COUNT, None), second))
    ]
    np.testing.assert_allclose(stored[0], stored[1], atol=1e-12)
    assert np.abs(stored[0] - LARGE[0]).max() > 1e-4


def test_a_conversion_while_marking_is_read_back_too(tmp_path):
    glb(tmp_path / "in.glb", *SCENES["two"])
    result = embed_file(tmp_path / "in.glb", tmp_path / "out.ply", KEY, id=ID, layers="both")
    mesh = read_mesh(tmp_path / "out.ply")
    assert authenticate(mesh, KEY).verdict == "authentic"
    found = unmark(mesh, KEY, result.certificate)
    assert np.abs(found.mesh.vertices - read_mesh(tmp_path / "in.glb").vertices).max() < 1e-5


def place_in_copy(mesh, part):
    """Return the middle of a place on one copy, and which vertices are near it."""
    centre = mesh.vertices[part * COUNT + 300]
    near = np.linalg.norm(mesh.vertices - centre, axis=1) < 0.45
    assert 15 < near.sum() < 100
    return centre, near


def altered_there(edited, part, centre):
    """Return what `authenticate` finds, which is altered around a place of one copy and nowhere else."""
    found = authenticate(edited, KEY)
    assert (found.verdict, found.id) == ("altered", ID)
    altered = np.flatnonzero(found.altered)
    assert len(altered) > 10
    assert set(altered // COUNT) == {part}
    assert np.linalg.norm(edited.vertices[altered] - centre, axis=1).max() < 0.9
    return found


def test_what_is_moved_in_one_copy_is_found_there(marked):
    mesh, part = read_mesh(marked[0] / "out.glb"), 1
    centre, near = place_in_copy(mesh, part)
    edited = Mesh(mesh.vertices + near[:, None] * [0.05, 0.0, 0.0], mesh.faces)
    assert altered_there(edited, part, centre).altered[near].mean() > 0.9
    assert extract(edited, KEY, search="plain").id == ID


def test_what_is_cut_from_one_copy_is_found_there(marked):
    mesh, part = read_mesh(marked[0] / "out.glb"), 0
    centre, near = place_in_copy(mesh, part)
    altered_there(Mesh(mesh.vertices, mesh.faces[~near[mesh.faces].any(axis=1)]), part, centre)


def test_a_copy_more_or_less_is_an_alteration(marked):
    folder, _ = marked
    mesh = read_mesh(folder / "out.glb")
    one = Mesh(mesh.vertices[:COUNT], mesh.faces[: len(mesh.faces) // 2])
    three = Mesh(
        np.concatenate([mesh.vertices, mesh.vertices[:COUNT] + np.array([0, 9, 0])]),
        np.concatenate([mesh.faces, mesh.faces[: len(mesh.faces) // 2] + 2 * COUNT]),
    )
    for other, missing in ((one, COUNT), (three, -COUNT)):
        found = authenticate(other, KEY)
        assert (found.verdict, found.points_missing) == ("altered", missing)
        assert extract(other, KEY, search="plain").id == ID


def test_the_mark_comes_off_all_copies(marked):
    folder, result = marked
    found = unmark(read_mesh(folder / "out.glb"), KEY, result.certificate)
    assert found.exact
    assert np.abs(found.mesh.vertices - read_mesh(folder / "in.glb").vertices).max() < 1e-5


def test_what_was_changed_in_the_file_is_brought_back_in_every_copy(marked, tmp_path):
    folder, _ = marked
    mesh = read_mesh(folder / "out.glb")
    once = np.linalg.norm(mesh.vertices[:COUNT] - mesh.vertices[300], axis=1) < 0.35
    turn = placed((3, 0, 0), 2)[:3, :3] @ np.linalg.inv(placed((0, 0, 0), 1)[:3, :3])
    shift = 0.2 * mesh.vertices[300] / np.linalg.norm(mesh.vertices[300])  # outwards
    moved = np.concatenate([once[:, None] * shift, once[:, None] * (turn @ shift)])
    write_mesh(mesh.with_vertices(mesh.vertices + moved), tmp_path / "edited.glb")
    edited = read_mesh(tmp_path / "edited.glb")
    assert authenticate(edited, KEY).altered.reshape(2, -1)[:, once].mean() > 0.9
    back = recover(edited, KEY).mesh
    assert back is not None
    off = np.linalg.norm(back.vertices - mesh.vertices, axis=1).reshape(2, -1)[:, once]
    assert off.mean() < 0.5 * 0.2
    np.testing.assert_allclose(off[0], off[1], atol=1e-5)


def test_what_was_cut_from_a_baked_copy_is_filled_in_its_place(marked):
    folder, _ = marked
    mesh = read_mesh(folder / "out.glb")
    near = np.linalg.norm(mesh.vertices - mesh.vertices[COUNT + 300], axis=1) < 0.35
    cut = Mesh(mesh.vertices, mesh.faces[~near[mesh.faces].any(axis=1)])
    found = recover(cut, KEY)
    assert found.mesh is not None
    assert found.faces_added > 0
    new = found.mesh.vertices[found.mesh.faces[-found.faces_added :]].mean(axis=1)
    assert np.linalg.norm(new - mesh.vertices[COUNT + 300], axis=1).max() < 0.6


def test_copies_too_small_for_the_ground_they_stand_on_carry_the_id_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(authentication_layer, "_READ", 1)  # others of the choices are read no better
    trees = [(0, placed((3 * i, 0, 0), i, 0.5)) for i in range(3)]
    wide = (PLANE[0] * [6.0, 6.0, 1.0], PLANE[1])
    glb(tmp_path / "in.glb", [SHAPE, wide], [(1, np.eye(4)), *trees])
    result = embed_file(tmp_path / "in.glb", tmp_path / "out.glb", KEY, id=ID)
    assert result.layers == "ownership"
    written = read_mesh(tmp_path / "out.glb")
    for mesh in (written, baked(written, tmp_path / "out.obj")):
        assert extract(mesh, KEY, search="plain").id == ID
    assert extract(written, KEY, reference=result.certificate).id == ID


def test_each_layer_alone_is_there_for_copies(tmp_path):
    mesh = glb(tmp_path / "in.glb", *SCENES["two"])
    alone = embed(mesh, KEY, id=ID, layers="ownership")
    assert extract(alone.mesh, KEY, search="plain").id == ID
    upper = embed(mesh, KEY, id=ID, layers="authentication")
    assert authenticate(upper.mesh, KEY).verdict == "authentic"
    assert authenticate(Mesh(upper.mesh.vertices, upper.mesh.faces), KEY).verdict == "authentic"


@pytest.mark.parametrize(
    "whole", [Whole(points=12, area=0.5), Whole(points=12, area=0.5, distinct=6), Whole()]
)
def test_a_payload_keeps_how_many_points_are_no_copies(whole):
    packed = pack("bytes", b"text", whole)
    assert unpack(packed) == Payload(kind="bytes", content=b"text", whole=whole)
