"""A glTF with other faces: what each vertex had, and all else in the file, stays."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.io import read_mesh, write_mesh
from meshmark.io.derived import derived, losses
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.remesh import can_remesh
from meshmark.mesh import Mesh
from tests.counting import some
from tests.io.gltf_opened import SHELLS, opened
from tests.io.gltf_samples import CUBE, CUBE_FACES, Sample, instances


def figure() -> Sample:
    """Return two cubes of different materials, the second skinned and with a morph target, below a moved node."""
    sample = Sample()
    for number in range(2):
        sample.put("materials", name=f"paint {number}")
    plain = sample.mesh(
        sample.array(CUBE, bounds=True), sample.array(CUBE_FACES.ravel(), "u1"), material=0,
        attributes={"TEXCOORD_0": sample.array(CUBE[:, :2] / 3)},
    )  # fmt: skip
    offsets = (CUBE * 0.1).astype("f4")
    target = sample.array(offsets)
    sample.tree["accessors"][target] |= {
        "min": offsets.min(axis=0).tolist(),
        "max": offsets.max(axis=0).tolist(),
    }
    weights = np.stack([np.arange(8) / 7, 1 - np.arange(8) / 7, np.zeros(8), np.zeros(8)], axis=1)
    bent = sample.mesh(
        sample.array(CUBE + np.array([5, 0, 0]), bounds=True), sample.array(CUBE_FACES.ravel(), "u1"), material=1,
        attributes={
            "JOINTS_0": sample.array(np.tile([0, 1, 0, 0], (8, 1)), "u1"),
            "WEIGHTS_0": sample.array(weights),
        },
        targets=[{"POSITION": target}],
    )  # fmt: skip
    bones = [sample.node(root=True, name="bone"), sample.node(root=True, name="tip")]
    skin = sample.put("skins", joints=bones)
    sample.node(mesh=plain, root=True, translation=[0, 3, 0])
    sample.node(mesh=bent, skin=skin, root=True)
    return sample


def cut(mesh: Mesh, gone: int) -> Mesh:
    """Return the mesh without its first faces, and a new vertex with one face on the last ones."""
    count = len(mesh.vertices)
    vertices = np.concatenate([mesh.vertices, mesh.vertices[-1:] + np.array([0.5, 0.0, 0.0])])
    faces = np.concatenate([mesh.faces[gone:], [[count, count - 1, count - 2]]])
    return derived(mesh, vertices, faces, np.append(np.arange(count), -1))


def corners(mesh: Mesh) -> set[bytes]:
    return {row.tobytes() for row in mesh.vertices[mesh.faces]}


@pytest.fixture(params=SHELLS)
def model(request, tmp_path):
    _, data, name = opened(figure(), request.param, tmp_path)
    path = tmp_path / name.replace("out", "in")
    path.write_bytes(data)
    return read_mesh(path)


def test_faces_go_and_come_and_the_rest_stays(model, tmp_path):
    changed = cut(model, 4)
    assert losses(changed) == ()
    out = tmp_path / f"out.{model.document.format}"
    report = write_mesh(changed, out)
    assert report.dropped == ()
    again = read_mesh(out)
    assert corners(again) == corners(changed)
    tree = again.document.document.container.tree
    before = model.document.document.container.tree
    for table in ("nodes", "skins", "materials"):
        assert tree[table] == before[table]
    assert [item["primitives"][0]["material"] for item in tree["meshes"]] == [0, 1]
    assert len(tree["meshes"][1]["primitives"][0]["targets"]) == 1


def test_vertices_keep_their_weights_and_texture(model, tmp_path):
    out = tmp_path / f"out.{model.document.format}"
    write_mesh(cut(model, 4), out)
    old, new = model.document.document, read_mesh(out).document.document

    def told(document, mesh, name):
        item = document.scene.primitives[mesh][0]
        places = document.scene.accessors[item.position].values(document.container.blob)
        values = open_accessor(document.container, item.attributes[name]).values(document.container.blob)
        return {place.tobytes(): tuple(value) for place, value in zip(places, values, strict=True)}

    for mesh, name in ((0, "TEXCOORD_0"), (1, "WEIGHTS_0"), (1, "JOINTS_0")):
        before, after = told(old, mesh, name), told(new, mesh, name)
        kept = after.keys() & before.keys()
        assert len(kept) >= 7
        assert all(after[place] == before[place] for place in some(kept))
    assert len(told(new, 1, "WEIGHTS_0")) == 9


def test_a_primitive_without_faces_stays_in_the_file(model, tmp_path):
    out = tmp_path / f"out.{model.document.format}"
    write_mesh(cut(model, len(CUBE_FACES)), out)
    tree = read_mesh(out).document.document.container.tree
    assert len(tree["meshes"]) == 2
    assert tree["nodes"] == model.document.document.container.tree["nodes"]


def test_what_is_shown_twice_is_written_anew_and_that_is_said(tmp_path):
    document, data, _ = opened(instances(), "glb", tmp_path)
    assert not can_remesh(document)
    (tmp_path / "in.glb").write_bytes(data)
    changed = cut(read_mesh(tmp_path / "in.glb"), 2)
    assert "separate meshes" in losses(changed)
    write_mesh(changed, tmp_path / "out.glb")
    assert len(read_mesh(tmp_path / "out.glb").faces) == len(changed.faces)
