"""OFF: header variants, faces, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import FormatError
from meshmark.io.off.parse import parse_off
from tests.io.text_samples import SAMPLES

FACES = b"3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
POINTS = b"0 0 0\n1 0 0\n0 1 0\n0 0 1\n"


def parse(data: bytes):  # type: ignore[no-untyped-def]
    return parse_off(data, Path("model.off"))


def test_faces_are_read_in_order() -> None:
    expected = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    assert parse(b"OFF\n4 4 6\n" + POINTS + FACES).faces.tolist() == expected
    assert parse(b"OFF 4 4 6 " + POINTS + FACES.replace(b"\n", b" ")).faces.tolist() == expected


def test_polygons_become_fans() -> None:
    document = parse(SAMPLES["off polygons and face colours"].data)
    assert document.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2], [1, 2, 3]]
    assert document.attributes().other == ("polygons", "face colours")


def test_variants_carry_their_columns() -> None:
    found = parse(SAMPLES["stcnoff"].data).attributes()
    assert found.normals is not None
    assert found.texcoords is not None
    assert found.colors is not None
    assert found.normals.tolist() == [[0, 0, 1]] * 4
    assert found.colors.tolist() == [[10, 20, 30, 40]] * 4
    assert found.texcoords.tolist() == [[0.25, 0.75]] * 4
    three = parse(SAMPLES["coff three"].data).attributes().colors
    assert three is not None
    assert three.tolist() == [[128, 64, 255, 255]] * 4
    plain = parse(SAMPLES["off"].data).attributes()
    assert (plain.normals, plain.texcoords, plain.colors, plain.other) == (None, None, None, ())


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"4 4 6\n" + POINTS + FACES, "starts with '4', expected OFF"),
        (b"POFF\n", "starts with 'POFF'"),
        (b"4OFF\n1 1 1\n0 0 0 1\n", "only points in three dimensions"),
        (b"nOFF\n4\n1 1 1\n", "only points in three dimensions"),
        (b"OFF BINARY\n\1\2\3", "binary OFF"),
        (b"OFF", "no counts"),
        (b"OFF\n4\n", "no counts"),
        (b"OFF\n4.5 4 0\n", "line 2 has '4.5' where a whole number is expected"),
        (b"OFF\n0 4 0\n", "declares 0 vertices"),
        (b"OFF\n-4 4 0\n", "declares -4 vertices"),
        (b"OFF\n4 0 0\n" + POINTS, "declares 0 faces, expected a surface"),
        (b"OFF\n4000000000 4000000000 0\n" + POINTS, "only 12 numbers follow"),
        (b"OFF\n4 4 0\n" + POINTS + b"3 0 1 2\n3 0 1", "is not complete"),
        (b"OFF\n4 4 0\n" + POINTS + b"3 0 1 2\n3 0 2 1", "is not complete"),
        (b"OFF\n4 4 0\n" + POINTS + b"1 1 1\n" + FACES, "line 11: more follows the 4 faces"),
        (b"OFF 4 4 0 " + POINTS.replace(b"\n", b" ") + b"3 0 1 x 3 1 2 3", "has 'x' where a whole number"),
        (b"OFF\n4 4 0\n" + POINTS.replace(b"1 0 0", b"1 x 0") + FACES, "line 4 has 'x' where a number"),
        (b"OFF\n4 4 0\n" + POINTS.replace(b"1 0 0", b"1 nan 0") + FACES, "line 4 has 'nan' where a finite"),
        (
            b"OFF\n4 4 0\n" + POINTS + FACES.replace(b"3 1 2 3", b"3 1 2 4"),
            "line 10: face 3 refers to vertex 4, expected 0 to 3",
        ),
        (b"OFF\n4 4 0\n" + POINTS + FACES.replace(b"3 1 2 3", b"3 1 2 -1"), "refers to vertex -1"),
        (
            b"OFF\n4 4 0\n" + POINTS + FACES.replace(b"3 1 2 3", b"4 1 2 3"),
            "line 10: face 3 declares 4 corners, but 3",
        ),
        (b"OFF\n4 4 0\n" + POINTS + FACES.replace(b"3 1 2 3", b"0 1 2 3"), "declares 0 corners"),
        (b"OFF\n4 4 0\n" + POINTS + FACES.replace(b"3 1 2 3", b"3 1 2 three"), "line 10 has 'three'"),
        ("OFF\n4 4 6\n".encode("utf-16"), "UTF-16"),
        (b"OFF\n4 4 0\n\0" + POINTS + FACES, "zero bytes"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "no faces"),
    ],
)
def test_what_breaks_the_format_is_refused_in_one_sentence(data: bytes, says: str) -> None:
    with pytest.raises(FormatError) as caught:
        parse(data)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_face_without_area_is_kept_and_gives_no_triangle() -> None:
    data = b"OFF\n4 3 0\n" + POINTS + b"3 0 1 2\n2 0 1\n1 3\n"
    document = parse(data)
    assert document.faces.tolist() == [[0, 1, 2]]
    assert document.patched(document.vertices, "a") == {"a": data}


def test_coincident_vertices_stay_coincident() -> None:
    document = parse(b"OFF\n4 2 0\n0.10 0 0\n1 0 0\n0 1 0\n0.1 0 0\n3 0 1 2\n3 3 1 2\n")
    moved = document.vertices + 0.123456789
    conformed = document.conform(moved)
    np.testing.assert_array_equal(conformed[0], conformed[3])
