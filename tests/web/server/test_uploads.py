"""Names of uploaded files, the model among them, and where a glTF has its files."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.errors import InputError
from meshmark.web.server.uploads import clean_name, model_among, put_in_places, stored
from tests.counting import Share


@pytest.mark.parametrize(
    ("given_name", "kept"),
    [
        ("ear.glb", "ear.glb"),
        ("C:\\models\\ear.glb", "ear.glb"),
        ("../../etc/passwd", "passwd"),
        ("Größe 2.obj", "Größe 2.obj"),
        ("--force.ply", "force.ply"),
        (".hidden.ply", "hidden.ply"),
        ("a\0b\n<c>.ply", "a_b__c_.ply"),
        ("x" * 300 + ".ply", "x" * 96 + ".ply"),
    ],
)
def test_names_become_harmless(given_name, kept):
    assert clean_name(given_name) == kept


def test_what_is_left_of_a_name_names_a_file_in_its_folder():
    with Share(0.5) as share:

        @given(st.text(max_size=150))
        def holds(name):
            share.case()
            try:
                kept = clean_name(name)
            except InputError:
                return
            share.asserted()
            assert Path(kept).name == kept
            assert kept[0] not in ".- "
            assert len(kept) <= 100
            assert kept.isprintable()

        holds()


@pytest.mark.parametrize("name", ["", "/", "..", "   ", "___"])
def test_a_file_without_a_name_is_refused(name):
    with pytest.raises(InputError, match="has no name"):
        clean_name(name)


def test_two_files_of_one_name_are_refused(tmp_path):
    stored(io.BytesIO(b"1"), "a/x.ply", tmp_path / "in")
    with pytest.raises(InputError, match=r"two of the uploaded files are called x\.ply"):
        stored(io.BytesIO(b"2"), "b/x.ply", tmp_path / "in")
    assert (tmp_path / "in/x.ply").read_bytes() == b"1"


def test_the_model_is_the_one_file_that_is_none_of_its_parts():
    paths = [Path(name) for name in ("skin.png", "model.mtl", "model.obj.gz", "model.bin")]
    assert model_among(paths) == Path("model.obj.gz")
    assert model_among([Path("scan")]) == Path("scan"), "its content may tell"
    with pytest.raises(InputError, match=r"a\.ply and b\.stl are both models"):
        model_among([Path("a.ply"), Path("b.stl")])
    with pytest.raises(InputError, match="none of the uploaded files is a model"):
        model_among([Path("a.png"), Path("b.bin")])


def test_the_files_of_a_gltf_go_where_it_says_and_never_outside(tmp_path):
    uris = [
        "textures/deep/skin.png",
        "../up.png",
        "/abs.png",
        "a/../../out.png",
        "data:image/png;base64,",
        "%2e%2e/x.png",
        7,
    ]
    tree = {"images": [{"uri": uri} for uri in uris], "buffers": [{"uri": "model.bin"}, {}, 3]}
    names = ("skin.png", "up.png", "abs.png", "out.png", "x.png", "model.bin")
    home = tmp_path / "in"
    home.mkdir()
    (home / "model.gltf").write_text(json.dumps(tree))
    for name in names:
        (home / name).write_text(name)
    put_in_places(home / "model.gltf", [home / name for name in names])
    found = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    beside = {f"in/{name}" for name in ("model.gltf", "up.png", "abs.png", "out.png", "x.png", "model.bin")}
    assert found == {*beside, "in/textures/deep/skin.png"}


@pytest.mark.parametrize("content", [b"", b"[", b"[]", b'{"images": 3}', b"\xff" * 10, b"[" * 100_000])
def test_a_broken_gltf_is_left_to_the_reader_of_the_format(tmp_path, content):
    (tmp_path / "a.gltf").write_bytes(content)
    (tmp_path / "skin.png").write_bytes(b"")
    put_in_places(tmp_path / "a.gltf", [tmp_path / "skin.png"])
    assert (tmp_path / "skin.png").exists()
