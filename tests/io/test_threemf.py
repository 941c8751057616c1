"""A save of a 3MF package rewrites coordinates in the model's XML; every other byte of the zip stays."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from meshmark.io.threemf.model_part import open_model
from meshmark.io.threemf.parse import ThreeMfDocument, parse_3mf
from tests.counting import some
from tests.io.threemf_samples import MODELS, POINTS, RELS, mesh, model, package, simple

HERE = Path("model.3mf")
NUMBER = re.compile(rb'(<(?:\w+:)?vertex\b[^>]*?\s[xyz]\s*=\s*["\'])[^"\']*')


def moved(document: ThreeMfDocument) -> Any:
    size = np.ptp(document.vertices, axis=0).max()
    return document.vertices + np.random.default_rng(3).normal(size=document.vertices.shape) * size * 1e-3


def parts(data: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.mark.parametrize("name", MODELS)
def test_only_coordinates_change(name: str) -> None:
    data = package(*MODELS[name])
    document = parse_3mf(data, HERE)
    assert document.patched(document.vertices.copy(), "a.3mf")["a.3mf"] == data
    vertices = moved(document)
    written = document.patched(vertices, "a.3mf")["a.3mf"]
    old, new = parts(data), parts(written)
    assert list(old) == list(new)
    changed = [part for part in old if old[part] != new[part]]
    assert changed
    for part in some(old):
        assert NUMBER.sub(rb"\1#", old[part]) == NUMBER.sub(rb"\1#", new[part]) or part in changed
        assert blanked(old[part]) == blanked(new[part])
    again = parse_3mf(written, HERE)
    assert again.vertices.tobytes() == document.conform(vertices).tobytes()
    assert np.array_equal(again.faces, document.faces)


def blanked(text: bytes) -> bytes:
    """Return XML with the coordinates of vertices replaced by #, tag by tag."""
    if not text.lstrip().startswith(b"<"):
        return text
    tag = re.compile(rb"<(?:\w+:)?vertex\b(?:[^>\"']|\"[^\"]*\"|'[^']*')*>")
    value = re.compile(rb"(\s[xyz]\s*=\s*)(?:\"[^\"]*\"|'[^']*')")
    return tag.sub(lambda match: value.sub(rb"\1#", match.group()), text)


@pytest.mark.parametrize("name", MODELS)
def test_the_quick_way_reads_what_the_parser_reads(name: str) -> None:
    for text in (MODELS[name][0], *MODELS[name][1].values()):
        quick, slow = (open_model("m", text.encode(), quick=flag) for flag in (True, False))
        assert list(quick.meshes) == list(slow.meshes)
        for key in some(quick.meshes):
            for field in ("vertices", "starts", "ends", "faces"):
                assert np.array_equal(getattr(quick.meshes[key], field), getattr(slow.meshes[key], field))
        assert [item.object_id for item in quick.items] == [item.object_id for item in slow.items]


def test_records_of_the_zip_file_stay() -> None:
    data = package(*MODELS["parts"])
    document = parse_3mf(data, HERE)
    written = document.patched(moved(document), "a.3mf")["a.3mf"]
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(io.BytesIO(written)) as new:
        assert old.comment == new.comment
        for before, after in some(zip(old.infolist(), new.infolist(), strict=True)):
            for field in (
                "filename",
                "date_time",
                "compress_type",
                "comment",
                "extra",
                "flag_bits",
                "create_system",
            ):
                assert getattr(before, field) == getattr(after, field)
        kept = [name for name in old.namelist() if not name.endswith(".model")]
        for before, after in some((old.getinfo(name), new.getinfo(name)) for name in kept):
            size = 30 + len(before.filename) + len(before.extra) + before.compress_size
            assert data[before.header_offset :][:size] == written[after.header_offset :][:size]


def test_data_descriptors_and_zip64_sizes_are_patched() -> None:
    class Pipe(io.BytesIO):
        def seekable(self) -> bool:
            return False

        def tell(self) -> int:
            raise OSError

    packed = Pipe()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("_rels/.rels", RELS)
        with archive.open("3D/Main.model", "w", force_zip64=True) as member:
            member.write(simple().encode())
        archive.writestr("last.txt", "end")
    data = packed.getvalue()
    document = parse_3mf(data, HERE)
    written = document.patched(moved(document), "a.3mf")["a.3mf"]
    assert parts(written)["last.txt"] == b"end"
    assert parse_3mf(written, HERE).vertices.tobytes() == document.conform(moved(document)).tobytes()


def test_transforms_and_units() -> None:
    points = np.array(POINTS, dtype=float)
    document = parse_3mf(package(*MODELS["components"]), HERE)
    turned = points @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]] + [5, 6, 7]
    expected = np.concatenate([turned * 2 + 1, points * 2 + 1, points])
    assert np.allclose(document.vertices, expected)
    assert len(document.faces) == 12
    assert np.allclose(parse_3mf(package(*MODELS["inches"]), HERE).vertices, points * 25.4)


def test_digits_resolve_the_model_and_keep_the_files_manner() -> None:
    fixed = [(f"{float(x):.3f}", f"{float(y):.3f}", f"{float(z):.3f}") for x, y, z in POINTS]
    document = parse_3mf(package(simple(points=fixed)), HERE)
    vertices = moved(document)
    vertices[1] = document.vertices[1]
    diagonal = np.linalg.norm(np.ptp(document.vertices, axis=0))
    assert np.abs(document.conform(vertices) - vertices).max() <= 0.51e-7 * diagonal
    text = parts(document.patched(vertices, "a")["a"])["3D/Main.model"]
    assert b'<vertex x="10.000" y="0.000" z="0.000"/>' in text
    words = re.findall(rb'[xyz]="([^"]*)"', text)
    assert {len(word.split(b".")[1]) for word in words[:3]} == {6}


def test_an_object_shown_twice_moves_by_the_mean() -> None:
    document = parse_3mf(
        package(model(f'<object id="1">{mesh()}</object>', '<item objectid="1"/>' * 2)), HERE
    )
    vertices = document.vertices.copy()
    vertices[2, 1] += 1.0
    assert np.allclose(document.conform(vertices)[[2, 6], 1], 21.0)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("name", ["simple", "single quotes", "parts"])
def test_utf16_stays_utf16(name: str, encoding: str) -> None:
    main, others = MODELS[name]
    main = main.replace("UTF-8", "UTF-16").replace("<model ", '<model note="\u00fc \U0001f600" ')
    wide = {part: text.encode(encoding) for part, text in {**others, "3D/Main.model": main}.items()}
    data = package(main, others)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = [(item, wide.get(item.filename, archive.read(item))) for item in archive.infolist()]
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for item, content in members:
            archive.writestr(item, content)
    document, plain = parse_3mf(packed.getvalue(), HERE), parse_3mf(data, HERE)
    assert document.patched(document.vertices, "a")["a"] == packed.getvalue()
    assert document.vertices.tobytes() == plain.vertices.tobytes()
    written = parts(document.patched(moved(document), "a")["a"])
    expected = parts(plain.patched(moved(plain), "a")["a"])
    for part in some(expected):
        assert written[part] == (expected[part].decode().encode(encoding) if part in wide else expected[part])


@pytest.mark.parametrize(
    "method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]
)
@pytest.mark.parametrize("marked", [True, False])
def test_every_way_of_packing_is_written_back(method: int, marked: bool) -> None:
    data = bytearray(package(*MODELS["parts"], method=method))
    if not marked:  # LZMA data need not end with a mark where the sizes are known
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for item in archive.infolist():
                data[item.header_offset + 6] &= ~2
        for place in [found.start() for found in re.finditer(b"PK\1\2", data)]:
            data[place + 8] &= ~2
    document = parse_3mf(bytes(data), HERE)
    written = document.patched(moved(document), "a.3mf")["a.3mf"]
    with zipfile.ZipFile(io.BytesIO(bytes(data))) as old, zipfile.ZipFile(io.BytesIO(written)) as new:
        assert [i.compress_type for i in old.infolist()] == [i.compress_type for i in new.infolist()]
        changed = [name for name in old.namelist() if old.read(name) != new.read(name)]
        assert all(name.endswith(".model") for name in some(changed))
    assert parse_3mf(written, HERE).vertices.tobytes() == document.conform(moved(document)).tobytes()


def test_part_names_with_escapes_and_backslashes_are_found() -> None:
    rels = RELS.replace("Main.model", "My%20Main.model")
    for name in ("3D/My Main.model", "3D/My%20Main.model", "3D\\My Main.model"):
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as archive:
            archive.writestr("_rels/.rels", rels)
            item = zipfile.ZipInfo("x")
            item.filename = name
            archive.writestr(item, simple())
        document = parse_3mf(packed.getvalue(), HERE)
        written = document.patched(moved(document), "a")["a"]
        assert list(parts(written)) == ["_rels/.rels", name]
        assert parse_3mf(written, HERE).vertices.tobytes() == document.conform(moved(document)).tobytes()
