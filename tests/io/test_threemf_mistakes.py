"""A 3MF package that is broken, hostile or out of reach is refused in one sentence that names the place."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.errors import FormatError, InputError
from meshmark.io.threemf.model_part import open_model
from meshmark.io.threemf.parse import parse_3mf
from tests.counting import Share
from tests.io.sentences import check_sentence
from tests.io.threemf_samples import MODELS, mesh, model, package, simple

HERE = Path("model.3mf")


def refused(main: str, pattern: str, others: dict[str, str] | None = None) -> None:
    with pytest.raises(FormatError, match=pattern):
        parse_3mf(package(main, others), HERE)


def test_each_mistake_is_named() -> None:
    laughs = simple().replace("<model", '<!DOCTYPE m [<!ENTITY a "lol"><!ENTITY b "&a;&a;">]>\n<model', 1)
    refused(laughs, "document type")
    refused(simple().replace('x="10"', 'x="nan"'), "x is 'nan'")
    refused(simple().replace('x="10"', 'x="1e999"'), "finite")
    refused(simple().replace('x="10"', 'x="1_0"'), "x is '1_0'")
    refused(simple().replace('x="10"', ""), "x is ''")
    refused(simple().replace('v1="1"', 'v1="4"'), "triangle 3 .* expected 0 to 3")
    refused(simple().replace('v1="1"', 'v1="-1"'), "expected an index")
    refused(simple().replace("</mesh>", ""), "broken XML at line")
    refused(simple().replace("millimeter", "furlong"), "unit 'furlong'")
    refused(simple().replace('item objectid="1"', 'item objectid="5"'), "no object '5'")
    refused(model(f'<object id="1">{mesh()}</object>', ""), "no triangles in any build item")
    refused(model(f'<object id="1">{mesh()}</object>' * 2), "id of its own")
    refused(simple().replace("<item ", '<item transform="1 2 3" '), "3 numbers, expected 12")
    refused("<html/>", "root element")
    refused(model("<a>" * 5000 + "</a>" * 5000), "more than 100 deep")
    loop = '<object id="1"><components><component objectid="1"/></components></object>'
    refused(model(loop), "contain themselves")
    for data, pattern in ((b"PK\3\4 nothing", "zip"), (package(simple())[:-40], "zip")):
        with pytest.raises(FormatError, match=pattern):
            parse_3mf(data, HERE)


def test_component_and_zip_bombs_are_bounded() -> None:
    objects = f'<object id="0">{mesh()}</object>'
    for level in range(1, 40):
        pair = f'<component objectid="{level - 1}"/>' * 2
        objects += f'<object id="{level}"><components>{pair}</components></object>'
    refused(model(objects, '<item objectid="39"/>'), "more than")
    refused(simple() + " " * 80_000_000, "no model of its size")


def test_positions_that_cannot_be_written() -> None:
    document = parse_3mf(package(simple()), HERE)
    with pytest.raises(InputError):
        document.conform(np.full((4, 3), np.inf))
    with pytest.raises(InputError):
        document.patched(document.vertices[1:], "a")


DATA = package(*MODELS["parts"], method=zipfile.ZIP_STORED)


def test_changed_and_cut_bytes() -> None:
    with Share(0.005) as share:  # every part has a checksum
        change_bytes(share)


@settings(max_examples=150, deadline=None)
@given(
    edits=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=2),
    cut=st.integers(0, 10**6) | st.none(),
)
def change_bytes(share: Share, edits: list[tuple[int, int]], cut: int | None) -> None:
    data = bytearray(DATA)
    for place, value in edits:
        data[place % len(data)] = value
    read_or_refuse(bytes(data if cut is None else data[: cut % len(data)]), share)


def test_changed_xml() -> None:
    with Share(0.01) as share:
        change_xml(share)


@settings(max_examples=150, deadline=None)
@given(
    edits=st.lists(
        st.tuples(st.integers(0, 10**6), st.sampled_from(b"<>/\"'= 0-.eE&!?vx")), min_size=1, max_size=4
    )
)
def change_xml(share: Share, edits: list[tuple[int, int]]) -> None:
    text = bytearray(MODELS["components"][0].encode())
    for place, value in edits:
        text[place % len(text)] = value
    read_or_refuse(package(text.decode("utf-8", "replace")), share)


def read_or_refuse(data: bytes, share: Share) -> None:
    """Read; where that works, use every method. Counts what was read."""
    share.case()
    try:
        document = parse_3mf(data, HERE)
        share.asserted()
        assert document.patched(document.vertices, "a")["a"] == data
        vertices = document.vertices + 0.25
        written = document.patched(vertices, "a")["a"]
        assert parse_3mf(written, HERE).vertices.tobytes() == document.conform(vertices).tobytes()
        document.summary()
        document.attributes()
    except InputError as error:
        check_sentence(str(error))


def test_broken_utf16_is_named() -> None:
    for content, says in (
        (b"\xff\xfe<\0\0", "UTF-16"),
        (b"\xff\xfe\0\xd8<\0", "UTF-16"),
        (b"<?\0x", "UTF-8"),
    ):
        with pytest.raises(FormatError, match=says):
            open_model("m", content)


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_errors_name_the_line_of_the_file(ending: str) -> None:
    text = simple().replace("\n", ending)
    for place in ("</vertices>", "</mesh>", "</model>"):
        broken = text.replace(place, f"{ending}<x:y/>{place}")
        line = len(broken[: broken.index("<x:y/>")].split(ending))
        assert f" line {line}: unbound prefix" in refusal(broken)


def refusal(main: str) -> str:
    with pytest.raises(FormatError) as caught:
        parse_3mf(package(main), HERE)
    return str(caught.value)


def test_encrypted_content_is_named() -> None:
    assert "3D/Main.model is encrypted (3MF secure content)" in refusal("%3McF" + "\1\2\3" * 50)
