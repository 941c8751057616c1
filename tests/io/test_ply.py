"""PLY: both binary orders, types, layouts, and what is refused."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import FormatError, InputError
from meshmark.io.ply.parse import parse_ply
from tests.counting import some
from tests.io.binary_samples import FACES, POINTS, TYPES, binary_ply
from tests.io.text_samples import SAMPLES


def parse(data: bytes):  # type: ignore[no-untyped-def]
    return parse_ply(data, Path("model.ply"))


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize(
    "kinds",
    [("float", "float", "float"), ("double",) * 3, ("float", "double", "int16"), ("int", "char", "int")],
)
@pytest.mark.parametrize("lists", [False, True])
@pytest.mark.parametrize("polygons", [False, True])
def test_binary(order: str, kinds: tuple[str, str, str], lists: bool, polygons: bool) -> None:
    data, offsets = binary_ply(order, kinds, lists=lists, polygons=polygons)
    document = parse(data)
    whole = [TYPES[kind] not in "fd" for kind in kinds]
    np.testing.assert_array_equal(document.vertices, np.where(whole, np.trunc(POINTS), POINTS))
    assert document.faces.tolist() == (
        [[0, 2, 1], [0, 1, 3], [0, 1, 3]] if polygons else [list(f) for f in FACES]
    )
    assert document.patched(document.vertices, "a")["a"] == data
    moved = document.vertices + np.pi / 3
    written = document.patched(moved, "a")["a"]
    conformed = document.conform(moved)
    np.testing.assert_array_equal(document.conform(conformed), conformed)
    expected = bytearray(data)
    for offset, value, kind in zip(offsets, moved.ravel().tolist(), kinds * len(POINTS), strict=True):
        code = TYPES[kind]
        struct.pack_into(order + code, expected, offset, value if code in "fd" else round(value))
    assert written == bytes(expected)
    np.testing.assert_array_equal(parse(written).vertices, conformed)


def test_one_moved_coordinate_changes_one_number() -> None:
    data, offsets = binary_ply("<", ("float",) * 3)
    document = parse(data)
    moved = document.vertices.copy()
    moved[2, 1] = 7
    written = document.patched(moved, "a")["a"]
    changed = {k for k in range(len(data)) if data[k] != written[k]}
    assert changed
    assert changed <= set(range(offsets[7], offsets[7] + 4))


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_headers_of_any_line_ending(ending: str) -> None:
    data, _ = binary_ply("<", ("float",) * 3)
    head, body = data.split(b"end_header\n")
    other = head.replace(b"\n", ending.encode()) + b"end_header" + ending.encode() + body
    np.testing.assert_array_equal(parse(other).vertices, parse(data).vertices)
    # The data may begin with a byte that looks like a line end.
    old_mac = other.replace(b"element camera 2" + ending.encode(), b"element camera 0" + ending.encode())
    assert other != old_mac


def test_data_that_begin_like_a_line_end() -> None:
    header = "ply\rformat binary_little_endian 1.0\relement vertex 3\r"
    header += "property uchar x\rproperty uchar y\rproperty uchar z\r"
    header += "element face 1\rproperty list uchar uchar vertex_index\rend_header\r"
    data = header.encode() + bytes([10, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 1, 2])
    assert parse(data).vertices.tolist() == [[10, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_whole_number_coordinates_in_text_stay_whole() -> None:
    header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty int y\nproperty int z\n"
    data = (
        header
        + "element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n10 0 0\n0 10 0\n3 0 1 2\n"
    ).encode()
    document = parse(data)
    moved = document.vertices + 0.6
    assert document.conform(moved).tolist() == [[1, 1, 1], [11, 1, 1], [1, 11, 1]]
    assert document.patched(moved, "a")["a"].endswith(b"end_header\n1 1 1\n11 1 1\n1 11 1\n3 0 1 2\n")


def test_beyond_the_range_of_the_type() -> None:
    for kinds, value in ((("float",) * 3, 1e39), (("char",) * 3, 200.0)):
        document = parse(binary_ply("<", kinds)[0])
        with pytest.raises(InputError, match="beyond the range"):
            document.conform(document.vertices + value)


def test_attributes() -> None:
    header = "ply\nformat ascii 1.0\nelement vertex 3\n"
    header += "".join(
        f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz", "s", "t", "quality")
    )
    header += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    header += "element face 1\nproperty list uchar int vertex_index\nproperty uchar red\n"
    header += "element edge 1\nproperty int vertex1\nend_header\n"
    rows = "".join(f"{k} {k * k} 0 0 0 1 0.5 {k} 9 1 2 {k}\n" for k in range(3))
    found = parse((header + rows + "3 0 1 2 5\n0\n").encode()).attributes()
    assert found.normals is not None
    assert found.texcoords is not None
    assert found.colors is not None
    assert found.normals.tolist() == [[0, 0, 1]] * 3
    assert found.texcoords.tolist() == [[0.5, 0], [0.5, 1], [0.5, 2]]
    assert found.colors.tolist() == [[1, 2, 0, 255], [1, 2, 1, 255], [1, 2, 2, 255]]
    assert found.other == ("vertex property quality", "face property red", "element edge")


def test_strips_are_decoded() -> None:
    assert parse(SAMPLES["ply strips"].data).faces.tolist() == [[0, 1, 2], [2, 1, 3], [3, 2, 1]]


HEAD = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
FACE = b"element face 1\nproperty list uchar int vertex_indices\n"
EDGE = b"element edge 1\nproperty int vertex1\nproperty int vertex2\n"
VERTICES_LAST = HEAD.replace(b"element", FACE + b"element") + b"end_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n"
BODY = b"end_header\n0 0 0\n1 0 0\n0 1 0\n"


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"ply\n", "no line 'end_header'"),
        (b"plyx\nend_header\n", "does not start with a line 'ply'"),
        (b"ply\nelement vertex 1\nend_header\n", "no line 'format'"),
        (b"ply\nformat ascii 2.0\nend_header\n", "expected 'format ascii 1.0'"),
        (b"ply\nformat binary_middle_endian 1.0\nend_header\n", "expected 'format ascii 1.0'"),
        (b"ply\nformat ascii 1.0\nelement vertex many\nend_header\n", "expected 'element NAME COUNT'"),
        (b"ply\nformat ascii 1.0\nelement vertex -3\nend_header\n", "expected 'element NAME COUNT'"),
        (b"ply\nformat ascii 1.0\nelement vertex 4000000000\nend_header\n", "more than the file can hold"),
        (
            b"ply\nformat ascii 1.0\nelement vertex " + b"9" * 5000 + b"\nend_header\n",
            "more than the file can hold",
        ),
        (b"ply\nformat ascii 1.0\nproperty float x\nend_header\n", "before any element"),
        (HEAD.replace(b"float z", b"quad z") + FACE + BODY, "with a known type"),
        (HEAD.replace(b"float z", b"list float float z") + FACE + BODY, "counts a list in float"),
        (HEAD.replace(b"float z", b"list uchar float z") + FACE + BODY + b"3 0 1 2\n", "is a list"),
        (HEAD + b"element vertex 3\n" + FACE + BODY, "declares an element twice"),
        (HEAD.replace(b"float z", b"float y") + FACE + BODY, "declares a property of 'vertex' twice"),
        (
            HEAD.replace(b"float z", b"float w") + FACE + BODY + b"3 0 1 2\n",
            "no element 'vertex' with properties x, y and z",
        ),
        (HEAD.replace(b"vertex 3", b"vertex 0") + FACE + b"end_header\n3 0 1 2\n", "no element 'vertex'"),
        (HEAD + BODY, "no faces"),
        (HEAD + FACE.replace(b"face 1", b"face 0") + BODY, "no faces"),
        (HEAD + FACE.replace(b"vertex_indices", b"corners") + BODY + b"3 0 1 2\n", "no faces"),
        (HEAD + FACE + BODY, "the data end before a list"),
        (HEAD + FACE + BODY + b"3 0 1\n", "the data end within the 1 rows of 'face'"),
        (VERTICES_LAST + b"1 1 1\n", "declares 3 vertices, but behind them stands what may be further ones"),
        (HEAD + FACE + BODY + b"3 0 1 3\n", "refers to vertex 3"),
        (HEAD + FACE + BODY + b"-3 0 1 2\n", "declares -3 members"),
        (HEAD + FACE + BODY + b"3 0 1 x\n", "has 'x' where a whole number is expected"),
        (HEAD + FACE + BODY + b"three 0 1 2\n", "'three' where a list length is expected"),
        (HEAD + FACE.replace(b"int vertex", b"float vertex") + BODY + b"3 0 1 2\n", "expected whole ones"),
        (HEAD + FACE + BODY.replace(b"1 0 0", b"1 nan 0") + b"3 0 1 2\n", "line 11 has 'nan'"),
        (HEAD + FACE.replace(b"face 1", b"face 2") + BODY + b"3 0 1 2", "the data end before a list"),
        (
            HEAD + FACE.replace(b"face 1", b"face 2") + EDGE + BODY + b"3 0 1 2\n",
            "the data end before a list",
        ),
        (HEAD + FACE + BODY.replace(b"1 0 0", b"1 x 0") + b"3 0 1 2\n", "line 11 has 'x'"),
        (b"\xff\xfep\0", "does not start"),
    ],
)
def test_what_breaks_the_format_is_refused_in_one_sentence(data: bytes, says: str) -> None:
    with pytest.raises(FormatError) as caught:
        parse(data)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_binary_data_may_end_between_faces_only() -> None:
    for polygons, sizes in ((False, (3, 3, 3, 3)), (True, (4, 3))):
        data, _ = binary_ply("<", ("float",) * 3, lists=polygons, polygons=polygons)
        between = {len(data) - sum(2 + 4 * size for size in sizes[k:]) for k in range(1, len(sizes))}
        for size in some(between):
            assert "rows of 'face'" in parse(data[:size]).remarks[0]
        for size in some(set(range(len(data))) - between, least=100):
            with pytest.raises(FormatError):
                parse(data[:size])


@pytest.mark.parametrize("order", ["<", ">"])
def test_surplus_bytes_are_kept_and_remarked_on(order: str) -> None:
    data, offsets = binary_ply(order, ("float",) * 3)
    for tail, says in ((b"\n", "1 byte follows"), (b"\0" * 700 + b"signature", "709 bytes follow")):
        document = parse(data + tail)
        assert document.remarks[0].startswith(says)
        assert document.patched(document.vertices, "a") == {"a": data + tail}
        written = document.patched(document.vertices + 0.5, "a")["a"]
        other = np.frombuffer(written, "u1") != np.frombuffer(data + tail, "u1")
        for place in some(np.flatnonzero(other)):
            assert any(offset <= place < offset + 4 for offset in offsets)
        assert written.endswith(tail)
    assert parse(data).remarks == ()


def test_whole_numbers_of_64_bits() -> None:
    header = HEAD.replace(b"ascii", b"binary_little_endian") + FACE.replace(b"uchar int", b"uint64 int64")
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    data = header + b"end_header\n" + positions + struct.pack("<4q", 3, 0, 1, 2)
    assert parse(data).faces.tolist() == [[0, 1, 2]]
    for corner in (2**40, -1):
        with pytest.raises(FormatError, match="refers to vertex"):
            parse(data[:-8] + struct.pack("<q", corner))


def test_binary_not_finite() -> None:
    data, offsets = binary_ply("<", ("float",) * 3)
    broken = bytearray(data)
    struct.pack_into("<f", broken, offsets[5], float("inf"))
    with pytest.raises(FormatError, match="vertex 1 has a coordinate that is not a finite number"):
        parse(bytes(broken))


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_vertex_that_no_face_uses_need_not_be_finite(order: str) -> None:
    header = HEAD.replace(b"vertex 3", b"vertex 5") + b"property float nx\n" + FACE + b"end_header\n"
    header = header.replace(b"ascii", b"binary_little_endian" if order == "<" else b"binary_big_endian")
    rows = np.array([[0, 0, 0, 5], [np.nan, 1, 2, 6], [1, 0, 0, 7], [0, 1, 0, np.nan], [1, 1, np.inf, 9]])
    data = header + rows.astype(f"{order}f4").tobytes() + struct.pack(f"{order}B3i", 3, 0, 2, 3)
    document = parse(data)
    assert document.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert document.faces.tolist() == [[0, 1, 2]]
    assert document.remarks == ("2 vertices without finite coordinates, used by no face, stay as they are",)
    assert document.patched(document.vertices, "a") == {"a": data}
    written = document.patched(document.vertices + 0.5, "a")["a"]
    rows[[0, 2, 3], :3] += 0.5
    assert written == header + rows.astype(f"{order}f4").tobytes() + data[-13:]
    with pytest.raises(FormatError, match="vertex 1 has a coordinate that is not a finite number"):
        parse(data[:-4] + struct.pack(f"{order}i", 1))


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_faces_without_corners_alone_are_no_surface(order: str) -> None:
    binary = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4" if "little" in order else ">f4").tobytes()
    rows = BODY[len(b"end_header\n") :] + b"0\n0\n" if order == "ascii" else binary + bytes(2)
    header = HEAD.replace(b"ascii", order.encode()) + FACE.replace(b"face 1", b"face 2") + b"end_header\n"
    with pytest.raises(FormatError, match="no faces"):
        parse(header + rows)
