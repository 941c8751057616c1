"""Fresh glTF and 3MF files hold what they were given, and read back in our reader and in trimesh."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from meshmark.document import Attributes
from meshmark.errors import InputError
from meshmark.io.gltf.convert import convert_glb, convert_gltf
from meshmark.io.gltf.parse import parse_glb, parse_gltf
from meshmark.io.threemf.convert import convert_3mf
from meshmark.io.threemf.parse import parse_3mf
from tests.io.gltf_samples import CUBE, CUBE_FACES, UNIT

HERE = Path("new")
FULL = Attributes(
    normals=UNIT,
    texcoords=CUBE[:, :2] / 3,
    colors=np.arange(32, dtype=np.uint8).reshape(8, 4),
    other=("groups",),
)


@pytest.mark.parametrize(("convert", "parse"), [(convert_glb, parse_glb), (convert_gltf, parse_gltf)])
def test_all_attributes_come_back(convert: Any, parse: Any) -> None:
    files, dropped = convert(CUBE, CUBE_FACES, FULL, "cube.any")
    assert list(files) == ["cube.any"]
    assert dropped == ("groups",)
    document = parse(files["cube.any"], HERE)
    assert np.array_equal(document.vertices, CUBE.astype("f4"))
    assert np.array_equal(document.faces, CUBE_FACES)
    found = document.attributes()
    assert np.allclose(found.normals, UNIT)
    assert np.allclose(found.texcoords, FULL.texcoords, atol=1e-6)
    assert np.array_equal(found.colors, FULL.colors)
    assert found.other == ()


def test_equal_meshes_give_equal_bytes() -> None:
    for convert in (convert_glb, convert_gltf, convert_3mf):
        assert convert(CUBE, CUBE_FACES, FULL, "a") == convert(CUBE, CUBE_FACES, FULL, "a")


def test_far_from_the_origin_no_digits_are_lost() -> None:
    far = CUBE + np.array([1e7, -3e6, 0.0])
    document = parse_glb(convert_glb(far, CUBE_FACES, Attributes(), "a")[0]["a"], HERE)
    assert np.abs(document.vertices - far).max() < 1e-6
    document = parse_3mf(convert_3mf(far, CUBE_FACES, Attributes(), "a")[0]["a"], HERE)
    assert np.abs(document.vertices - far).max() < 1e-8


def test_index_types_keep_clear_of_the_restart_mark() -> None:
    for count, code in ((65535, 5123), (65536, 5125)):
        points = np.random.default_rng(0).normal(size=(count, 3))
        faces = np.array([[0, 1, count - 1]])
        files, _ = convert_gltf(points, faces, Attributes(), "a")
        assert json.loads(files["a"])["accessors"][1]["componentType"] == code
        assert np.array_equal(parse_gltf(files["a"], HERE).faces, faces)


def test_normals_without_direction_are_dropped_by_name() -> None:
    files, dropped = convert_glb(CUBE, CUBE_FACES, Attributes(normals=UNIT * [[0]] * 8), "a")
    assert dropped == ("normals, as some have no direction",)
    assert parse_glb(files["a"], HERE).attributes().normals is None


def test_what_cannot_be_written_is_refused() -> None:
    none = np.empty((0, 3), dtype=np.int64)
    for convert in (convert_glb, convert_gltf, convert_3mf):
        with pytest.raises(InputError, match="cannot write a"):
            convert(CUBE, none, Attributes(), "a")
    with pytest.raises(InputError, match="32-bit"):
        convert_glb(CUBE * 1e39, CUBE_FACES, Attributes(), "a")


def test_3mf_keeps_the_surface_and_names_the_rest() -> None:
    faces = np.vstack([CUBE_FACES, [[3, 3, 5]]])
    files, dropped = convert_3mf(CUBE, faces, FULL, 'a "quoted" <name>.3mf')
    document = parse_3mf(next(iter(files.values())), HERE)
    assert np.abs(document.vertices - CUBE).max() < 1e-8
    assert np.array_equal(document.faces, CUBE_FACES)
    assert dropped == (
        *("groups", "normals", "texture coordinates", "vertex colours"),
        "1 triangles that name a point twice",
    )


def test_trimesh_reads_them_alike() -> None:
    for convert, kind in ((convert_glb, "glb"), (convert_3mf, "3mf")):
        files, _ = convert(CUBE, CUBE_FACES, Attributes(), "a")
        other = trimesh.load_scene(io.BytesIO(files["a"]), file_type=kind, process=False).to_mesh()
        assert np.allclose(other.vertices, CUBE, atol=1e-6)
        assert np.array_equal(other.faces, CUBE_FACES)
