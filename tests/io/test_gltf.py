"""A save of a glTF patches positions and their bounds, nothing else; what is read back was foretold."""

from __future__ import annotations

import base64
import json
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from meshmark.errors import FormatError, InputError
from meshmark.io.gltf.parse import GltfDocument, parse_glb, parse_gltf
from tests.counting import some
from tests.io.gltf_opened import SHELLS, moved, opened
from tests.io.gltf_samples import (
    CUBE,
    SAMPLES,
    Sample,
    cube,
    interleaved,
    rich,
    sparse,
)

_BOUNDS = re.compile(rb'("(?:min|max)"\s*:\s*\[)([^\]]*)(\])')


def reread(files: dict[str, bytes], name: str, folder: Path) -> GltfDocument:
    """Write the files into a folder of their own and read them back."""
    target = folder / "written"
    target.mkdir(exist_ok=True)
    for other, data in files.items():
        (target / other).write_bytes(data)
    return (parse_glb if name.endswith(".glb") else parse_gltf)(files[name], target / name)


def chunks_of(data: bytes) -> list[bytes]:
    """Return the chunks of a GLB, by an independent reading."""
    found, at = [], 12
    while at < len(data):
        size = struct.unpack_from("<I", data, at)[0]
        found.append(data[at + 8 : at + 8 + size])
        at += 8 + size
    assert struct.unpack_from("<I", data, 8)[0] == len(data)
    assert all(len(chunk) % 4 == 0 for chunk in some(found, least=2))
    return found


def taken_apart(data: bytes, files: dict[str, bytes]) -> tuple[bytes, bytes, list[bytes]]:
    """Return (JSON text, buffer, other chunks) of a file in any shell, by an independent reading."""
    if data.startswith(b"glTF"):
        text, blob, *others = chunks_of(data)
        return text.rstrip(b" "), blob, others
    uri = json.loads(data)["buffers"][0]["uri"]
    if uri.startswith("data:"):
        return data.replace(uri.encode(), b"URI"), base64.b64decode(uri.split(",")[1]), []
    return data.replace(uri.encode(), b"URI"), files[uri.replace("%20", " ")], []


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize("name", SAMPLES)
def test_nothing_moved_gives_the_same_bytes(name: str, shell: str, tmp_path: Path) -> None:
    document, data, out = opened(SAMPLES[name](), shell, tmp_path)
    files = document.patched(document.vertices.copy(), out)
    assert next(iter(files)) == out
    assert files.pop(out) == data
    assert bool(files) == (shell == "external")
    assert files == {other: (tmp_path / other).read_bytes() for other in files}
    assert np.array_equal(document.conform(document.vertices), document.vertices)


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize("name", SAMPLES)
def test_only_positions_and_their_bounds_change(name: str, shell: str, tmp_path: Path) -> None:
    sample = SAMPLES[name]()
    document, data, out = opened(sample, shell, tmp_path)
    files = dict(document.patched(moved(document), out))
    beside = {path.name: path.read_bytes() for path in tmp_path.glob("*.bin")}
    text, blob, chunks = taken_apart(data, beside)
    new_text, new_blob, new_chunks = taken_apart(files[out], files)
    changed = np.frombuffer(blob, np.uint8) != np.frombuffer(new_blob, np.uint8)
    mask = np.zeros(len(blob), bool)
    mask[: len(sample.blob)] = sample.position_mask()
    assert not changed[~mask].any()
    assert changed[mask].mean() > 0.1
    assert chunks == new_chunks

    def without_numbers(match: re.Match[bytes]) -> bytes:
        return match.group(1) + re.sub(rb"[-+0-9.eE]+", b"#", match.group(2)) + match.group(3)

    assert _BOUNDS.sub(without_numbers, text) == _BOUNDS.sub(without_numbers, new_text)
    assert new_text != text
    assert expected_tree(sample, new_blob, document) == without_buffers(json.loads(new_text))


def without_buffers(tree: Any) -> Any:
    return {key: value for key, value in tree.items() if key != "buffers"}


def expected_tree(sample: Sample, blob: bytes, document: GltfDocument) -> Any:
    """Return the JSON that the buffer asks for: bounds of POSITION accessors as their float32 data say."""
    tree = json.loads(sample.json())
    for part in document.scene.parts:
        record = tree["accessors"][part.accessor]
        view = tree["bufferViews"][record["bufferView"]]
        dtype = np.dtype({5120: "<i1", 5122: "<i2", 5123: "<u2", 5126: "<f4"}[record["componentType"]])
        start, step = view.get("byteOffset", 0), view.get("byteStride", 3 * dtype.itemsize)
        rows = np.array([np.frombuffer(blob, dtype, 3, start + i * step) for i in range(record["count"])])
        if "sparse" in record:
            values = tree["bufferViews"][record["sparse"]["values"]["bufferView"]]["byteOffset"]
            rows[[2, 5]] = np.frombuffer(blob, dtype, 6, values).reshape(2, 3)
        record["min"], record["max"] = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
    return without_buffers(tree)


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize("name", SAMPLES)
def test_conform_foretells_what_is_read_back(name: str, shell: str, tmp_path: Path) -> None:
    document, _, out = opened(SAMPLES[name](), shell, tmp_path)
    vertices = moved(document)
    foretold = document.conform(vertices)
    again = reread(dict(document.patched(vertices, out)), out, tmp_path)
    assert again.vertices.tobytes() == foretold.tobytes()
    assert np.array_equal(again.faces, document.faces)
    assert np.array_equal(again.conform(foretold), foretold)


def test_positions_land_where_asked(tmp_path: Path) -> None:
    for name in ("cube", "interleaved", "sparse", "modes", "shared_positions"):
        document, _, _ = opened(SAMPLES[name](), "glb", tmp_path)
        vertices = moved(document)
        assert np.abs(document.conform(vertices) - vertices).max() < 3e-7


def test_rows_that_stay_keep_their_bytes(tmp_path: Path) -> None:
    document, data, _ = opened(cube(), "glb", tmp_path)
    vertices = document.vertices.copy()
    vertices[3] += 0.01
    written = document.patched(vertices, "a.glb")["a.glb"]
    start = data.index(np.asarray(CUBE, "<f4").tobytes())
    shift = len(written) - len(data)
    before, after = data[start : start + 96], written[start + shift : start + shift + 96]
    assert before[:36] == after[:36]
    assert before[48:] == after[48:]
    assert before[36:48] != after[36:48]


def test_attributes_for_other_formats(tmp_path: Path) -> None:
    found = opened(interleaved(), "glb", tmp_path)[0].attributes()
    assert np.allclose(found.normals, [0, 0, 1])
    assert np.allclose(found.texcoords, np.column_stack([CUBE[:, 0], 1 - CUBE[:, 1]]), atol=1e-6)
    assert found.colors is None
    other = opened(rich(), "glb", tmp_path)[0].attributes().other
    assert {"materials", "skins", "animations", "morph targets", "extensions"} <= set(other)


def test_external_buffer_gets_the_name_of_the_model(tmp_path: Path) -> None:
    document, _, _ = opened(cube(), "external", tmp_path)
    files = document.patched(moved(document), "marked copy.gltf")
    assert list(files) == ["marked copy.gltf", "marked copy.bin"]
    assert json.loads(files["marked copy.gltf"])["buffers"][0]["uri"] == "marked%20copy.bin"
    same_name = document.patched(moved(document), "in.gltf")
    assert list(same_name) == ["in.gltf", "old buffer.bin"]
    taken = document.patched(moved(document), "old buffer.gltf")
    assert "old buffer.bin" not in taken
    assert (tmp_path / "old buffer.bin").read_bytes() == bytes(cube().blob)


def test_side_files_are_the_images(tmp_path: Path) -> None:
    sample = rich()
    names = ("skin%201.png", "gone.png", "../secret.png", "private.txt", ".ssh/hidden.png", "link.png")
    sample.tree["images"] += [{"uri": name} for name in names]
    image = b"\x89PNG\r\n\x1a\n"
    (tmp_path / ".ssh").mkdir()
    (tmp_path / "skin 1.png").write_bytes(image)
    (tmp_path / ".ssh" / "hidden.png").write_bytes(image)
    (tmp_path / "private.txt").write_bytes(b"no image")
    (tmp_path / "link.png").symlink_to(tmp_path / "skin 1.png")
    document, _, _ = opened(sample, "external", tmp_path)
    assert document.side_files() == (tmp_path / "skin 1.png",)


def test_a_buffer_is_not_read_through_a_link(tmp_path: Path) -> None:
    sample = cube()
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "buffer.bin").write_bytes(sample.blob)
    (tmp_path / "sub").symlink_to(tmp_path / "there")
    with pytest.raises(FormatError, match=r"sub/buffer.bin .* cannot be read: it is reached through a link"):
        parse_gltf(sample.json(uri="sub/buffer.bin"), tmp_path / "in.gltf")


def test_buffers_without_positions_are_side_files(tmp_path: Path) -> None:
    sample = cube()
    (tmp_path / "old buffer.bin").write_bytes(sample.blob)
    (tmp_path / "more.bin").write_bytes(b"12345678")
    text = sample.json(uri="old%20buffer.bin").replace(
        b'"buffers": [', b'"buffers": [ {"uri": "more.bin", "byteLength": 8},'
    )
    text = text.replace(b'"buffer": 0', b'"buffer": 1')
    document = parse_gltf(text, tmp_path / "in.gltf")
    assert document.side_files() == (tmp_path / "more.bin",)
    files = document.patched(moved(document), "new.gltf")
    assert list(files) == ["new.gltf", "new1.bin"]
    assert [item["uri"] for item in json.loads(files["new.gltf"])["buffers"]] == ["more.bin", "new1.bin"]


def test_overlapping_accessors_move_together(tmp_path: Path) -> None:
    sample = cube()
    tail = sample.accessor(0, CUBE[4:].astype("f4"), bounds=True, byteOffset=48)
    sample.node(mesh=sample.mesh(tail, sample.array([0, 1, 2, 1, 2, 3], "u1")))
    document, _, out = opened(sample, "glb", tmp_path)
    vertices = document.vertices.copy()
    vertices[4] += 0.5
    foretold = document.conform(vertices)
    assert np.allclose(foretold[8] - document.vertices[8], 0.25)
    again = reread(dict(document.patched(vertices, out)), out, tmp_path)
    assert again.vertices.tobytes() == foretold.tobytes()
    tree = again.container.tree["accessors"]
    assert tree[tail]["max"] == foretold[8:].max(axis=0).tolist()


def test_overlapping_coordinates_are_refused(tmp_path: Path) -> None:
    sample = cube()
    part = sample.accessor(0, CUBE[4:].astype("f4"), bounds=True, byteOffset=44)
    sample.node(mesh=sample.mesh(part, sample.array([0, 1, 2], "u1")))
    with pytest.raises(FormatError, match="same bytes"):
        opened(sample, "glb", tmp_path)


@pytest.mark.parametrize("use", ["NORMAL", "target", "image"])
def test_bytes_shared_with_other_data_are_refused(use: str, tmp_path: Path) -> None:
    sample = cube()
    primitive = sample.tree["meshes"][0]["primitives"][0]
    if use == "NORMAL":
        primitive["attributes"]["NORMAL"] = 0
    elif use == "target":
        primitive["targets"] = [{"POSITION": 0}]
    else:
        sample.put("images", bufferView=0, mimeType="image/png")
    document, data, out = opened(sample, "glb", tmp_path)
    assert document.patched(document.vertices, out)[out] == data
    with pytest.raises(FormatError, match="shares bytes"):
        document.patched(moved(document), out)


def test_sparse_without_base_refuses_to_move_implied_zeros(tmp_path: Path) -> None:
    sample = sparse()
    record = sample.tree["accessors"][0]
    del record["bufferView"]
    document, _, out = opened(sample, "glb", tmp_path)
    vertices = document.vertices.copy()
    vertices[5] += 0.1
    again = reread(dict(document.patched(vertices, out)), out, tmp_path)
    assert again.vertices.tobytes() == document.conform(vertices).tobytes()
    vertices[0] += 0.1
    with pytest.raises(InputError, match="implied zero"):
        document.patched(vertices, out)


def test_unreachable_coordinates_are_refused(tmp_path: Path) -> None:
    document, _, out = opened(cube(), "glb", tmp_path)
    with pytest.raises(InputError, match="range"):
        document.patched(document.vertices * 1e39, out)
    with pytest.raises(InputError, match="shape"):
        document.conform(document.vertices[1:])


@pytest.mark.shared
def test_textured_models_lose_nothing(shared_data: Path) -> None:
    paths = sorted((shared_data / "textured").glob("*.glb"))
    assert paths
    for path in some(paths):
        data = path.read_bytes()
        document = parse_glb(data, path)
        assert document.patched(document.vertices, "a.glb")["a.glb"] == data
        vertices = moved(document)
        written = document.patched(vertices, "a.glb")["a.glb"]
        again = parse_glb(written, path)
        assert again.vertices.tobytes() == document.conform(vertices).tobytes()
        used = {part.accessor for part in document.scene.parts}
        ours, theirs = document.container, again.container
        for index in some(used):
            rows, new = again.points.values[again.points.slots[index]], theirs.tables["accessors"][index]
            assert new["min"] == rows.min(axis=0).tolist()
            assert new["max"] == rows.max(axis=0).tolist()
        for index, (old, new) in some(
            enumerate(zip(ours.tables["accessors"], theirs.tables["accessors"], strict=True))
        ):
            left_out = {"min", "max"} if index in used else set()
            assert {name: new[name] for name in new.keys() - left_out} == {
                name: old[name] for name in old.keys() - left_out
            }
            assert old.keys() == new.keys()
        mask = np.zeros(len(ours.blob), bool)
        mask[document.points.address[:, None] + np.arange(12)] = True
        assert np.array_equal(ours.blob[~mask], theirs.blob[~mask])
