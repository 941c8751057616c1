"""Compressed glTF: read as its plain form, saved unmoved byte for byte, saved moved without compression."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import DracoPy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.errors import FormatError, InputError
from meshmark.io import read_mesh, write_mesh
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.codecs import decode
from meshmark.io.gltf.container import Container, open_glb
from meshmark.io.gltf.parse import GltfDocument, parse_glb, parse_gltf
from meshmark.io.gltf.streams import Stream, _check_size
from meshmark.io.gltf.unpack import COMPRESSIONS, compressions
from tests.counting import Share, some
from tests.io.compressed_samples import draco_grid, with_meshopt
from tests.io.gltf_samples import SAMPLES, Sample
from tests.io.test_gltf_hostile import JUNK, paths_in, read_or_refuse

HERE = Path("nowhere/model.glb")
MESHOPT = [name for name in COMPRESSIONS if "meshopt" in name]


def tree_of(glb: bytes) -> dict[str, Any]:
    return json.loads(glb[20 : 20 + struct.unpack_from("<I", glb, 12)[0]])


def stored(container: Container, index: int) -> np.ndarray:
    return np.ascontiguousarray(open_accessor(container, index).raw(container.blob))


@pytest.mark.parametrize(
    ("name", "extension"), [*((name, MESHOPT[0]) for name in SAMPLES), ("rich", MESHOPT[1])]
)
def test_meshopt_reads_as_the_plain_file(name: str, extension: str) -> None:
    plain = parse_glb(SAMPLES[name]().glb(), HERE)
    packed = with_meshopt(SAMPLES[name](), extension)
    glb = packed.glb()
    document = parse_glb(glb, HERE)
    assert document.summary()["compression"] == [extension]
    assert np.array_equal(document.vertices, plain.vertices)
    assert np.array_equal(document.faces, plain.faces)
    assert document.patched(document.vertices, "a.glb") == {"a.glb": glb}
    for number in some(range(len(plain.container.tables["accessors"]))):
        assert np.array_equal(stored(document.container, number), stored(plain.container, number))


@pytest.mark.parametrize(
    ("name", "extension"), [*((name, MESHOPT[1]) for name in SAMPLES), ("rich", MESHOPT[0])]
)
def test_a_moved_save_keeps_all_but_positions_and_compression(name: str, extension: str) -> None:
    plain = parse_glb(SAMPLES[name]().glb(), HERE)
    document = parse_glb(with_meshopt(SAMPLES[name](), extension).glb(), HERE)
    target = document.conform(document.vertices + 0.01)
    glb = document.patched(target, "a.glb")["a.glb"]
    again = parse_glb(glb, HERE)
    assert again.summary()["compression"] == []
    assert np.array_equal(again.vertices, target)
    old, new = plain.container.tree, tree_of(glb)
    changing = ("bufferViews", "buffers", "accessors")
    assert {key: value for key, value in new.items() if key not in changing} == {
        key: value for key, value in old.items() if key not in changing
    }
    for before, after in some(zip(old["accessors"], new["accessors"], strict=True)):
        assert {**before, "min": 0, "max": 0} == {**after, "min": 0, "max": 0}
    moved = set(plain.scene.accessors)
    for number in some(set(range(len(old["accessors"]))) - moved):
        assert np.array_equal(stored(again.container, number), stored(plain.container, number))
    assert b"unknown!" in glb  # a chunk that the specification does not know


def test_no_compressed_copy_of_the_surface_is_left_behind() -> None:
    for sample in (draco_grid(), with_meshopt(SAMPLES["rich"]())):
        document = parse_glb(sample.glb(), HERE)
        compressed = bytes(sample.blob)
        glb = document.patched(document.vertices + 0.01, "a.glb")["a.glb"]
        views = list(sample.tree["bufferViews"])
        streams = [view.get("extensions", {}).get(MESHOPT[0], None) for view in views] + [
            views[item["extensions"]["KHR_draco_mesh_compression"]["bufferView"]]
            for mesh in sample.tree["meshes"]
            for item in mesh["primitives"]
            if "extensions" in item
        ]
        for item in some(item for item in streams if item):
            start = item["byteOffset"]
            assert compressed[start : start + item["byteLength"]] not in glb


def test_draco_gives_what_its_own_decoder_gives() -> None:
    sample = draco_grid()
    mesh = DracoPy.decode(bytes(sample.blob))
    document = parse_glb(sample.glb(), HERE)
    assert document.summary()["compression"] == ["KHR_draco_mesh_compression"]
    assert np.array_equal(document.vertices, mesh.points)
    assert np.array_equal(document.faces, mesh.faces)
    attributes = document.container.tables["meshes"][0]["primitives"][0]["attributes"]
    assert np.array_equal(
        stored(document.container, attributes["NORMAL"]), mesh.get_attribute_by_unique_id(3)["data"]
    )
    assert np.array_equal(
        stored(document.container, attributes["_JOINT"]), mesh.get_attribute_by_unique_id(5)["data"]
    )
    glb = document.patched(document.vertices + 0.5, "a.glb")["a.glb"]
    assert np.array_equal(parse_glb(glb, HERE).vertices, document.vertices + 0.5)
    tree = tree_of(glb)
    assert tree["nodes"] == sample.tree["nodes"]
    assert "extensionsUsed" not in tree
    assert "extensions" not in tree["meshes"][0]["primitives"][0]


def test_an_accessor_with_other_users_is_copied() -> None:
    sample = draco_grid()
    count = sample.tree["accessors"][0]["count"]
    own = np.arange(3 * count, dtype="<f4").reshape(-1, 3)
    sample.tree["accessors"][0]["bufferView"] = sample.view(own.tobytes())  # a fallback, also used by points
    sample.node(mesh=sample.mesh(0, mode=0))
    document = parse_glb(sample.glb(), HERE)
    meshes = document.container.tables["meshes"]
    points, sheet = meshes[1]["primitives"][0], meshes[0]["primitives"][0]
    assert np.array_equal(stored(document.container, points["attributes"]["POSITION"]), own)
    assert np.array_equal(
        stored(document.container, sheet["attributes"]["POSITION"]), document.vertices.astype("<f4")
    )


def test_a_fallback_that_nothing_else_uses_is_not_kept() -> None:
    sample = draco_grid()
    own = np.arange(3 * sample.tree["accessors"][0]["count"], dtype="<f4").tobytes()
    sample.tree["accessors"][0]["bufferView"] = sample.view(own)
    document = parse_glb(sample.glb(), HERE)
    assert own not in document.patched(document.vertices + 0.5, "a.glb")["a.glb"]


@pytest.mark.parametrize("inside", [True, False])
def test_gltf_with_its_buffer_inside_or_beside(tmp_path: Path, inside: bool) -> None:
    sample = with_meshopt(SAMPLES["rich"]())
    path = tmp_path / "model.gltf"
    if inside:
        import base64

        sample.tree["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(sample.blob).decode()
    else:
        sample.tree["buffers"][0]["uri"] = "model.bin"
        (tmp_path / "model.bin").write_bytes(sample.blob)
    path.write_bytes(sample.json())
    mesh = read_mesh(path)
    before = {item.name: item.read_bytes() for item in tmp_path.iterdir()}
    target = mesh.document.conform(mesh.vertices + 0.01)
    report = write_mesh(mesh.with_vertices(target), tmp_path / "out.gltf")
    assert report.decompressed == ("EXT_meshopt_compression",)
    assert np.array_equal(read_mesh(tmp_path / "out.gltf").vertices, target)
    assert {name: (tmp_path / name).read_bytes() for name in before} == before
    (tmp_path / "same").mkdir()
    assert write_mesh(mesh, tmp_path / "same" / "model.gltf").decompressed == ()
    assert {item.name: item.read_bytes() for item in (tmp_path / "same").iterdir()} == before


def refused(sample: Sample, pattern: str) -> None:
    with pytest.raises(FormatError, match=pattern):
        parse_glb(sample.glb(), HERE)


def test_streams_that_do_not_fit_their_file_are_refused() -> None:
    sample = draco_grid()
    sample.tree["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"][
        "NORMAL"
    ] = 9
    refused(sample, "no attribute with the id 9")
    sample = draco_grid()
    sample.tree["accessors"][1]["type"] = "VEC2"
    refused(sample, "accessor 1 is a VEC2, its Draco stream has 3 columns")
    sample = draco_grid()
    sample.tree["accessors"][1]["componentType"] = 5121
    refused(sample, "accessor 1 holds uint8, its Draco stream other numbers")
    sample = draco_grid()
    sample.blob[:] = sample.blob[:40] + bytes(len(sample.blob) - 40)
    refused(sample, "mesh 0, primitive 0: a Draco stream|damaged")
    sample = with_meshopt(SAMPLES["cube"]())
    record = sample.tree["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]
    record["count"] = 2**30
    refused(sample, "claims to unpack to")
    record["count"], record["byteStride"] = 8, 10
    refused(sample, "rows of 10 bytes")
    record["byteStride"], record["byteLength"] = 12, 10**6
    refused(sample, "ends at byte")


def test_parse_gltf_says_what_compresses(tmp_path: Path) -> None:
    document = parse_glb(draco_grid().glb(), HERE)
    assert isinstance(document, GltfDocument)
    assert compressions(open_glb(draco_grid().glb(), HERE)) == ("KHR_draco_mesh_compression",)
    assert compressions(document.container) == ()
    with pytest.raises(InputError):
        parse_gltf(draco_grid().json(uri="gone.bin"), tmp_path / "a.gltf")


BUILDERS = {
    "draco": draco_grid,
    "meshopt": lambda: with_meshopt(SAMPLES["rich"]()),
    "quantised": lambda: with_meshopt(SAMPLES["quantised"](), "KHR_meshopt_compression"),
}
PATHS = {name: paths_in(build().tree) for name, build in BUILDERS.items()}


def test_junk_anywhere_in_the_tree_of_a_compressed_file(monkeypatch: pytest.MonkeyPatch) -> None:
    # In this process, for speed: whole streams only, as broken ones are none of this test's business.
    whole = bytes(draco_grid().blob)

    def decoded(streams: Sequence[Stream]) -> list[Any]:
        _check_size(sum(item.unpacked for item in streams), sum(len(item.data) for item in streams))
        if any(item.codec == "draco" and item.data != whole for item in streams):
            raise FormatError("broken")
        return [decode(item.data, item.codec, **item.parameters) for item in streams]

    monkeypatch.setattr("meshmark.io.gltf.unpack.decode_streams", decoded)
    with Share(0.1) as share:
        put_junk(share)


@settings(max_examples=250, deadline=None)
@given(data=st.data())
def put_junk(share: Share, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(BUILDERS)))
    sample = BUILDERS[name]()
    for path in data.draw(st.lists(st.sampled_from(PATHS[name]), min_size=1, max_size=3)):
        place: Any = sample.tree
        try:
            for key in path[:-1]:
                place = place[key]
            if data.draw(st.booleans()):
                place[path[-1]] = data.draw(JUNK)
            else:
                del place[path[-1]]
        except (KeyError, IndexError, TypeError):
            continue
    try:
        glb = sample.glb()
    except (KeyError, TypeError, ValueError):  # a list that was put into itself is no JSON
        return
    read_or_refuse(glb, True, share)
