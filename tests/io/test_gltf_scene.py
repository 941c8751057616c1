"""Where the nodes, strips and skins of a glTF put its vertices."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from meshmark.io import read_mesh, write_mesh
from meshmark.io.gltf.parse import parse_glb, parse_gltf
from tests.io.gltf_opened import opened
from tests.io.gltf_samples import CUBE, CUBE_FACES, SAMPLES, cube, instances


def test_instances_share_the_mean_of_their_displacements(tmp_path: Path) -> None:
    document, _, _ = opened(instances(), "glb", tmp_path)
    plain, deep, tilted = (document.vertices[i : i + 8] for i in (0, 8, 16))
    # Independent of the node code: scipy's rotation, the matrix written out by hand.
    turn = Rotation.from_quat([0.5, 0.5, -0.5, 0.5]).as_matrix()
    assert np.allclose(plain, CUBE)
    assert np.allclose(deep, (CUBE * [1, -2, 0.5] + [0.25, 5, 1e-3]) @ turn.T + [3, 0, 0])
    assert np.allclose(tilted, CUBE @ np.array([[2, 0.5, 0], [0, 2, 0], [0, 0.25, 2]]) + [10, 20, 30])
    vertices = document.vertices.copy()
    vertices[4] += [0.3, 0, 0]
    shift = document.conform(vertices) - document.vertices
    assert np.allclose(shift[4], [0.1, 0, 0], atol=1e-6)
    assert np.allclose(shift[8 + 4], turn @ [0.1, 0, 0], atol=1e-6)
    assert not np.delete(shift, [4, 12, 20], axis=0).any()


def test_all_showings_moving_alike_is_exact(tmp_path: Path) -> None:
    document, _, _ = opened(instances(), "glb", tmp_path)
    local = CUBE + np.random.default_rng(0).normal(size=CUBE.shape) * 0.01
    sample = cube()
    start = sample.tree["bufferViews"][0]["byteOffset"]
    other = instances()
    other.blob[start : start + 96] = local.astype("<f4").tobytes()
    wanted = parse_glb(other.glb(), tmp_path / "b.glb").vertices
    assert np.abs(document.conform(wanted) - wanted).max() < 1e-6


MOVED = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3]
HALF = np.sqrt(0.5)


@pytest.mark.parametrize(
    ("node", "expected"),
    [
        ({"matrix": [*MOVED, 0.99999994]}, CUBE + np.array([1, 2, 3])),
        ({"matrix": [*MOVED, 1], "translation": [0, 0, 0], "scale": [5, 5, 5]}, CUBE + np.array([1, 2, 3])),
        ({"rotation": [0, 0, 0, 0]}, CUBE),
        ({"rotation": [0, 0, 0, 2]}, CUBE),
        ({"rotation": [0, 0, HALF + 0.02, HALF + 0.02]}, CUBE[:, [1, 0, 2]] * [-1, 1, 1]),
        ({"rotation": [0, 0, 3e-200, 3e-200]}, CUBE[:, [1, 0, 2]] * [-1, 1, 1]),
    ],
)
def test_transforms_that_are_not_quite_valid_are_read_as_viewers_read_them(
    tmp_path: Path, node: dict[str, Any], expected: Any
) -> None:
    sample = cube()
    sample.tree["nodes"][0] |= node
    document = parse_glb(sample.glb(), tmp_path / "model.glb")
    assert np.allclose(document.vertices, expected, atol=1e-6)
    moved = document.patched(document.vertices + 0.25, "model.glb")["model.glb"]
    assert np.allclose(parse_glb(moved, tmp_path / "model.glb").vertices, document.vertices + 0.25, atol=1e-6)


def test_a_backslash_in_a_uri_counts_as_a_slash(tmp_path: Path) -> None:
    sample = cube()
    (tmp_path / "tex").mkdir()
    (tmp_path / "tex" / "m.bin").write_bytes(sample.blob)
    (tmp_path / "model.gltf").write_bytes(sample.json(uri="tex\\m.bin"))
    mesh = read_mesh(tmp_path / "model.gltf")
    (tmp_path / "out").mkdir()
    write_mesh(mesh.with_vertices(mesh.vertices + 0.25), tmp_path / "out" / "model.gltf")
    assert np.allclose(read_mesh(tmp_path / "out" / "model.gltf").vertices, mesh.vertices + 0.25, atol=1e-6)
    assert (tmp_path / "tex" / "m.bin").read_bytes() == sample.blob


def test_strips_and_fans_wind_as_the_specification_says(tmp_path: Path) -> None:
    document, _, _ = opened(SAMPLES["modes"](), "glb", tmp_path)
    strip, fan = document.faces[:3], document.faces[3:6] - 8
    assert strip.tolist() == [[0, 1, 2], [1, 3, 2], [2, 3, 6]]
    assert fan.tolist() == [[1, 2, 0], [2, 3, 0], [3, 4, 0]]
    assert np.array_equal(document.faces[6:] - 13, np.arange(36).reshape(12, 3))


def test_shared_positions_appear_once(tmp_path: Path) -> None:
    document, _, _ = opened(SAMPLES["shared_positions"](), "glb", tmp_path)
    assert np.array_equal(document.vertices, CUBE.astype("f4"))
    assert np.array_equal(document.faces, np.concatenate([CUBE_FACES[i::3] for i in range(3)]))


def test_skinned_mesh_stands_where_its_joints_put_it(tmp_path: Path) -> None:
    sample = cube()
    sample.tree["nodes"][0]["skin"] = 0
    sample.tree["nodes"][0]["translation"] = [99, 99, 99]  # ignored
    scale, move = 100.0, np.array([1.0, 2.0, 3.0])
    joints = [sample.put("nodes", translation=[1, 2, 3], scale=[scale] * 3), sample.put("nodes")]
    # each joint's matrix, seen from where the joint stands now, is the same: the model is at rest
    matrices = np.tile(np.eye(4), (2, 1, 1))
    matrices[1, :3, :3] *= scale
    matrices[1, :3, 3] = move
    rows = matrices.transpose(0, 2, 1).reshape(2, 16)
    sample.put("skins", joints=joints, inverseBindMatrices=sample.array(rows, plain=True))
    sample.tree["scenes"][0]["nodes"] += joints
    document, _, _ = opened(sample, "glb", tmp_path)
    np.testing.assert_allclose(document.vertices, CUBE * scale + move, rtol=1e-6)


@pytest.mark.shared
def test_scene_positions_agree_with_trimesh(shared_data: Path) -> None:
    for name in ("cube.glb", "nested.glb", "pins.glb", "BoxTextured.glb", "rgb_cube_with_primitives.gltf"):
        path = shared_data / "hostile" / "trimesh" / name
        document = (parse_glb if name.endswith("glb") else parse_gltf)(path.read_bytes(), path)
        other = trimesh.load_scene(path, process=False).to_mesh()
        ours, theirs = document.vertices[document.faces], other.vertices[other.faces]
        assert np.allclose(sorted_rows(ours), sorted_rows(theirs), atol=1e-5)


def sorted_rows(triangles: Any) -> Any:
    centres = np.round(triangles.mean(axis=1), 4)
    return centres[np.lexsort(centres.T)]
