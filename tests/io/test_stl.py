"""STL: text, binary, binary that starts with `solid`, and the normals that follow."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import FormatError, InputError
from meshmark.io.stl.normals import facet_normals, stale_facets
from meshmark.io.stl.parse import parse_stl
from tests.io.binary_samples import CORNERS, NORMALS, binary_stl
from tests.io.text_samples import SAMPLES


def parse(data: bytes):  # type: ignore[no-untyped-def]
    return parse_stl(data, Path("model.stl"))


def text() -> bytes:
    facets = [
        f"facet normal {n[0]:f} {n[1]:f} {n[2]:f}\nouter loop\n"
        + "".join(f"vertex {x:e} {y:e} {z:e}\n" for x, y, z in corners)
        + "endloop\nendfacet\n"
        for n, corners in zip(NORMALS, CORNERS, strict=True)
    ]
    return ("solid test\n" + "".join(facets) + "endsolid test\n").encode()


@pytest.mark.parametrize("header", [b"made by a test", b"solid but binary", b"solid\nfacet normal"])
def test_binary(header: bytes) -> None:
    data = binary_stl(header)
    document = parse(data)
    np.testing.assert_array_equal(document.vertices, CORNERS.reshape(-1, 3))
    assert document.faces.tolist() == np.arange(12).reshape(4, 3).tolist()
    assert document.patched(document.vertices, "a")["a"] == data
    moved = document.vertices @ [[0, 1, 0], [0, 0, 1], [1, 0, 0]] + 0.1
    written = document.patched(moved, "a")["a"]
    conformed = document.conform(moved)
    np.testing.assert_array_equal(conformed, moved.astype(np.float32))
    np.testing.assert_array_equal(document.conform(conformed), conformed)
    for k in range(4):
        *numbers, attribute = struct.unpack_from("<12fH", written, 84 + 50 * k)
        np.testing.assert_array_equal(np.reshape(numbers[3:], (3, 3)), conformed.reshape(-1, 3, 3)[k])
        assert attribute == 1000 + k
        expected = (-1.0, 0.0, 0.0) if k == 0 else NORMALS[k]
        np.testing.assert_allclose(numbers[:3], expected, atol=1e-6)
    assert written[:84] == data[:84]
    assert document.attributes().other == ("facet attributes",)


def test_text_normals_follow_where_they_were_right() -> None:
    data = text()
    document = parse(data)
    assert document.patched(document.vertices, "a")["a"] == data
    moved = document.vertices @ [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    words = document.patched(moved, "a")["a"].decode().split()
    normals = [tuple(words[k + 1 : k + 4]) for k, word in enumerate(words) if word == "normal"]
    assert normals[0] == ("-1.000000", "0.000000", "0.000000")
    assert [tuple(map(float, normal)) for normal in normals[1:]] == NORMALS[1:]
    vertices = [words[k + 1 : k + 4] for k, word in enumerate(words) if word == "vertex"]
    np.testing.assert_array_equal(np.array(vertices, dtype=float), document.conform(moved))


def test_facets_that_stay_keep_their_normals() -> None:
    data = binary_stl().replace(struct.pack("<3f", 0, 0, -1), struct.pack("<3f", 0, 1e-4, -1), 1)
    document = parse(data)
    moved = document.vertices.copy()
    moved[3] += 0.25
    written = document.patched(moved, "a")["a"]
    assert written[: 84 + 50] == data[: 84 + 50]


def test_normals() -> None:
    np.testing.assert_allclose(facet_normals(CORNERS)[:3], [[0, 0, -1], [0, -1, 0], [-1, 0, 0]])
    for scale in (1e-30, 1e30, 1e200):
        np.testing.assert_allclose(facet_normals(CORNERS * scale)[:3], facet_normals(CORNERS)[:3])
    assert facet_normals(CORNERS)[3].tolist() == [0, 0, 0]
    stored = np.array([*NORMALS, (np.nan, 0, 0)])
    before = np.concatenate([CORNERS, CORNERS[:1]])
    assert stale_facets(stored, before, before + 1).tolist() == [True, False, False, False, False]
    assert not stale_facets(stored, before, before).any()


def test_several_solids_and_broken_normals() -> None:
    document = parse(SAMPLES["stl"].data)
    assert document.summary()["solids"] == 2
    assert document.attributes().other == ("solids",)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "has 0 bytes"),
        (b"x" * 79 + b"\0", "has 80 bytes"),
        (b"x" * 800, "text without a line 'solid'"),
        (binary_stl() + binary_stl()[84:134], "declares 4 facets, but 50 bytes follow them that look like"),
        (binary_stl()[:80] + bytes(4) + binary_stl()[84:] + b"x", "declares 0 facets"),
        (binary_stl()[:80] + b"\x09\0\0\0" + binary_stl()[84:], "declares 9 facets"),
        (binary_stl()[:80] + b"\5\0\0\0" + binary_stl()[84:] + b"x", "declares 5 facets"),
        (
            text().replace(b"solid test\n", b"facet normal 0 0 1\nsolid test\n", 1),
            "where 'outer' is expected",
        ),
        (binary_stl()[:-1], "declares 4 facets, so 284 bytes are expected, but the file has 283"),
        (b"x" * 80 + bytes(4), "no faces"),
        (
            binary_stl().replace(struct.pack("<f", 5), struct.pack("<f", float("nan")), 1),
            "facet 3 has a coordinate",
        ),
        (b"solid x\nendsolid x\n", "no facets"),
        (text().replace(b"endloop\n", b"", 1), "line 7 has 'endfacet' where 'endloop' is expected"),
        (text().replace(b"vertex 5.000000e+00", b"vertex five", 1), "line 25 has 'five' where a number"),
        (text().replace(b"vertex 5.000000e+00", b"vertex inf", 1), "line 25 has 'inf' where a finite number"),
        (text().replace(b"normal 1.000000", b"normal x", 1), "line 23 has 'x'"),
        (
            text().replace(b"endfacet\nendsolid", b"endsolid"),
            "the facet that begins on line 23 is not complete",
        ),
        ("solid".encode("utf-16"), "UTF-16"),
    ],
)
def test_what_breaks_the_format_is_refused_in_one_sentence(data: bytes, says: str) -> None:
    with pytest.raises(FormatError) as caught:
        parse(data)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_new_positions_must_fit() -> None:
    document = parse(binary_stl())
    with pytest.raises(InputError, match="beyond the range"):
        document.conform(document.vertices + 1e39)
    with pytest.raises(InputError, match="shape"):
        document.patched(document.vertices[:3], "a")


@pytest.mark.parametrize(
    "tail", [b"\0", b"\n", bytes(512), b"SIGNED" * 30, struct.pack("<12fH", *[7e30] * 12, 0)]
)
def test_bytes_behind_the_facets_are_kept_and_remarked_on(tail: bytes) -> None:
    document = parse(binary_stl() + tail)
    assert document.vertices.tolist() == CORNERS.reshape(-1, 3).tolist()
    verb = "byte follows" if len(tail) == 1 else "bytes follow"
    assert document.remarks[0].startswith(f"{len(tail)} {verb} the data that the header declares")
    assert document.patched(document.vertices, "a") == {"a": binary_stl() + tail}
    moved = document.vertices + 0.25
    plain = parse(binary_stl())
    assert document.patched(moved, "a")["a"] == plain.patched(moved, "a")["a"] + tail


@pytest.mark.parametrize("count", [0, 0xFFFFFFFF, 5, 8])
def test_a_count_beyond_what_is_there_stays(count: int) -> None:
    data = binary_stl()[:80] + struct.pack("<I", count) + binary_stl()[84:]
    document = parse(data)
    assert document.vertices.tolist() == CORNERS.reshape(-1, 3).tolist()
    assert document.remarks == (f"the header declares {count:,} facets, 4 facets are there",)
    moved = document.vertices + 0.25
    written = document.patched(moved, "a")["a"]
    assert written == data[:84] + parse(binary_stl()).patched(moved, "a")["a"][84:]


def test_a_text_that_ends_early_is_remarked_on() -> None:
    assert parse(SAMPLES["stl without endsolid"].data).remarks == ("the file ends without a line 'endsolid'",)
    assert parse(text()).remarks == ()
