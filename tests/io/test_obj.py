"""OBJ: index forms, side files, attributes at seams, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import FormatError
from meshmark.io import read_mesh, write_mesh
from meshmark.io.obj.parse import parse_obj
from meshmark.io.save import WriteReport
from meshmark.mesh import Mesh
from tests.io.text_samples import SAMPLES

POINTS = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"


def parse(data: bytes, path: Path = Path("model.obj")):  # type: ignore[no-untyped-def]
    return parse_obj(data, path)


def test_every_form_of_corner() -> None:
    lines = b"f 1 2 3\nf 1/1 2/1 4/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 4/1/1\nf 1/ 2// 3/1/\nf -4 -3 -1\n"
    faces = parse(POINTS + b"vt 0 0\nvn 0 0 1\n" + lines).faces.tolist()
    assert faces == [[0, 1, 2], [0, 1, 3], [0, 1, 2], [0, 1, 3], [0, 1, 2], [0, 1, 3]]


def test_negative_indices_count_from_the_face() -> None:
    data = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 9 9 9\nf -4 -3 -2\nf 1 2 4\n"
    assert parse(data).faces.tolist() == [[0, 1, 2], [0, 1, 2], [0, 1, 3]]


def test_rich_file() -> None:
    document = parse(SAMPLES["obj"].data)
    assert document.faces.tolist() == [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    facts = document.summary()
    assert (facts["groups"], facts["materials"], facts["texture_coordinates"], facts["normals"]) == (
        2,
        1,
        2,
        1,
    )


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "no 'v' lines"),
        (b"hello world\n", "no 'v' lines"),
        (POINTS, "no faces"),
        (POINTS + b"p 1\nl 1 2\n", "no faces"),
        (POINTS + b"f 1 2\n", "no faces"),
        (POINTS + b"f 1 2 5\n", "line 5 has the corner '5', but 4 vertices are defined"),
        (POINTS + b"f 1 2 0\n", "line 5 has the corner '0'"),
        (POINTS + b"f 1 2 -5\n", "line 5 has the corner '-5'"),
        (POINTS + b"f 1 2 99999999999999999999\n", "line 5 has the corner"),
        (POINTS + b"f 1 2 x\n", "line 5 has 'x' where a whole number is expected"),
        (POINTS + b"f 1 2 3.0\n", "line 5 has '3.0'"),
        (POINTS + b"f 1 2 /3\n", "line 5 has ''"),
        (POINTS + b"f 1/1/1/1 2 3\n", "expected up to three indices"),
        (POINTS + b"f\nf  # none\n", "no faces"),
        (POINTS + b"v 1 2\nf 1 2 3\n", "line 5: 'v' has 2 numbers, expected 3"),
        (POINTS + b"v 1 two 3\nf 1 2 3\n", "line 5 has 'two' where a number is expected"),
        (POINTS + b"v 1 inf 3\nf 1 2 5\n", "line 5 has 'inf' where a finite number is expected"),
        (POINTS + b"v 1 2 1.#IND\nf 1 2 5\n", "line 5 has '1.#IND' where a finite number is expected"),
        (b"v nan 0 0\n" * 3 + b"f 1 2 3\n", "line 1 has 'nan' where a finite number is expected"),
        (POINTS + b"v 1 2 1.#I\nf 1 2 3\n", "line 5 has '1.#I' where a number is expected"),
        (POINTS + b"f 1 \\\n2 \\\n7\n", "line 7 has the corner '7'"),
        (b"\xff\xfev\0", "UTF-16"),
    ],
)
def test_what_breaks_the_format_is_refused_in_one_sentence(data: bytes, says: str) -> None:
    with pytest.raises(FormatError) as caught:
        parse(data)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_seams_keep_every_corner() -> None:
    data = POINTS + b"vt 0 0\nvt 1 0\nvt 0 1\nvt 0.5 0.5\nf 1/1 2/2 3/3\nf 1/4 3/3 4/1\nf 2/2 1/4 4/1\n"
    document = parse(data)
    found = document.attributes()
    assert found.seams is not None
    assert found.texcoords is not None
    points, faces = found.seams
    assert points.tolist() == [0, 0, 1, 2, 3]
    np.testing.assert_array_equal(points[faces], document.faces)
    table = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0.5]])
    np.testing.assert_array_equal(found.texcoords[faces], table[[[0, 1, 2], [3, 2, 0], [1, 3, 0]]])


def test_attributes_without_seams_are_per_vertex() -> None:
    data = POINTS + b"v 5 5 5\nvn 0 0 1\nvn 1 0 0\nf 2//1 1//2 3//1\nf 2//1 3//1 4//2\n"
    found = parse(data).attributes()
    assert found.seams is None
    assert found.normals is not None
    assert found.normals[:4].tolist() == [[1, 0, 0], [0, 0, 1], [0, 0, 1], [1, 0, 0]]


def test_what_no_other_format_keeps_is_named() -> None:
    other = parse(SAMPLES["obj"].data).attributes().other
    assert {"objects", "groups", "smoothing groups", "materials", "lines", "points"} <= set(other)
    assert "texture coordinates of some faces" in other
    partial_colors = parse(POINTS + b"v 1 1 1 0.5 0.5 0.5\nf 1 2 3\n").attributes()
    assert partial_colors.colors is None
    assert "vertex colours of some vertices" in partial_colors.other


def test_vertex_colours() -> None:
    colors = parse(SAMPLES["obj colours"].data).attributes().colors
    assert colors is not None
    assert colors.tolist() == [[26, 51, 76, 255]] * 4


def test_material_files_are_found_but_only_inside_the_folder(tmp_path: Path) -> None:
    home = tmp_path / "home"
    (home / "maps").mkdir(parents=True)
    (tmp_path / "secret.mtl").write_text("newmtl x\n")
    (home / "with space.mtl").write_text(
        "newmtl a\nmap_Kd -s 1 1 1 maps/skin.png\nbump ..\\..\\secret.png\nmap_Ks gone.png\nrefl passwords.png\n"
    )
    (home / "maps" / "skin.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    (home / "passwords.png").write_bytes(b"no image")
    (home / "notes.txt").write_text("no materials\n")
    (home / "link.mtl").symlink_to(tmp_path / "secret.mtl")
    data = b"mtllib with space.mtl\nmtllib ../secret.mtl\nmtllib /etc/passwd\nmtllib link.mtl\n"
    data += b"mtllib notes.txt\nmtllib\n"
    document = parse(data + POINTS + b"f 1 2 3\n", home / "model.obj")
    assert document.side_files() == (home / "with space.mtl", home / "maps" / "skin.png")


def test_what_is_not_finite_stays_where_no_face_uses_it() -> None:
    """The vertices that are left out are left out of the attributes too, with and without seams."""
    data = (
        b"v 0 0 0 1 0 0\nv nan 0 0 0 1 0\nv 1 0 0 0 0 1\nv 0 1 0 1 1 0\nv 0 0 1 0 1 1\n"
        b"vt nan 0\nvt 1 inf\nvt 0 1\nvn nan nan nan\n"
    )
    for faces, points in ((b"f 1/1/1 3/2/1 4/3/1\nf 1/2/1 4/3/1 5/1/1\n", 5), (b"f 1/1/1 3/2/1 4/3/1\n", 4)):
        document = parse(data + faces)
        assert document.remarks == ("1 vertex without finite coordinates, used by no face, stays as it is",)
        found = document.attributes()
        owners, corners = (np.arange(4), document.faces) if found.seams is None else found.seams
        assert len(owners) == points
        np.testing.assert_array_equal(owners[corners], document.faces)
        assert found.texcoords is not None
        assert found.normals is not None
        assert found.colors is not None
        table = np.array([[np.nan, 0], [1, np.inf], [0, 1]])
        np.testing.assert_array_equal(found.texcoords[corners[0]], table)
        assert np.isnan(found.normals[corners[0]]).all()
        assert len(found.colors) == points
        assert found.colors[corners[0]][:, :3].tolist() == [[255, 0, 0], [0, 0, 255], [255, 255, 0]]


def converted(suffix: str, tmp_path: Path) -> tuple[Mesh, WriteReport]:
    """Return a model whose attributes are not all finite as it is read from another format, and what was said."""
    more = b"vt nan 1\nvt 0 inf\nvn 1.#IND 0 0\nf 1/1/1 2/2/1 3/1/1\nf 1/1/1 3/2/1 4/1/1\n"
    (tmp_path / "a.obj").write_bytes(POINTS + more)
    mesh = read_mesh(tmp_path / "a.obj")
    report = write_mesh(mesh, tmp_path / f"b{suffix}")
    again = read_mesh(tmp_path / f"b{suffix}")
    np.testing.assert_allclose(again.vertices[again.faces], mesh.vertices[mesh.faces])
    return again, report


@pytest.mark.parametrize("suffix", [".off", ".ply", ".obj"])
def test_a_conversion_to_text_or_ply_keeps_what_is_not_finite(suffix: str, tmp_path: Path) -> None:
    again, _ = converted(suffix, tmp_path)
    assert again.document is not None
    texcoords = again.document.attributes().texcoords
    assert texcoords is not None
    assert not np.isfinite(texcoords).all()


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_a_conversion_to_gltf_drops_what_is_not_finite_and_says_so(suffix: str, tmp_path: Path) -> None:
    _, report = converted(suffix, tmp_path)
    assert "texture coordinates, as some are not finite numbers" in report.dropped
    assert "normals, as some have no direction" in report.dropped


@pytest.mark.parametrize("suffix", [".stl", ".3mf"])
def test_a_conversion_to_what_holds_no_attributes_says_so(suffix: str, tmp_path: Path) -> None:
    _, report = converted(suffix, tmp_path)
    assert {"texture coordinates", "normals"} <= set(report.dropped)
