"""Whatever the bytes, reading a glTF gives a mesh or one sentence."""

from __future__ import annotations

import copy
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.errors import FormatError, InputError
from meshmark.io.gltf.parse import parse_glb, parse_gltf
from tests.counting import Share
from tests.io.gltf_samples import SAMPLES, Sample, cube, instances, rich
from tests.io.sentences import check_sentence

HERE = Path("nowhere/model.gltf")
NUMBERS = [-1, 0, 1, 3, 1.0, 1.5, 5126, 2**31, 2**63, 10**400, 1e308]
LISTS = [[], [0], [[]], [{}], [None], [1e300] * 3, [2.0] * 16]
JUNK = st.sampled_from(
    [None, True, *NUMBERS, *LISTS, "", "POSITION", "a.bin", {}, {"bufferView": 0}, {"a": {}}]
)


def read_or_refuse(data: bytes, glb: bool, share: Share) -> None:
    """Read; where that works, use every method. Counts what was read."""
    share.case()
    try:
        document = (parse_glb if glb else parse_gltf)(data, HERE)
        share.asserted()
        assert np.isfinite(document.vertices).all()
        assert 0 <= document.faces.min() <= document.faces.max() < len(document.vertices)
        assert document.patched(document.vertices, "out")["out"] == data
        document.summary()
        document.side_files()
        document.conform(document.vertices + 0.01)
        document.patched(document.vertices + 0.01, "out")
        document.attributes()
    except InputError as error:
        check_sentence(str(error))


def paths_in(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    found = [path] if path else []
    pairs = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in pairs:
        found += paths_in(value, (*path, key))
    return found


TREES = {name: json.loads(SAMPLES[name]().embedded()) for name in ("rich", "sparse", "quantised", "modes")}
PATHS = {name: paths_in(tree) for name, tree in TREES.items()}


def test_junk_anywhere_in_the_tree() -> None:
    with Share(0.1) as share:
        put_junk(share)


@settings(max_examples=250, deadline=None)
@given(data=st.data())
def put_junk(share: Share, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(TREES)))
    tree = copy.deepcopy(TREES[name])
    for path in data.draw(st.lists(st.sampled_from(PATHS[name]), min_size=1, max_size=3)):
        place = tree
        try:
            for key in path[:-1]:
                place = place[key]
            if data.draw(st.booleans()):
                place[path[-1]] = data.draw(JUNK)
            else:
                del place[path[-1]]
        except (KeyError, IndexError, TypeError):
            continue
    read_or_refuse(json.dumps(tree).encode(), False, share)


def test_changed_and_cut_bytes() -> None:
    with Share(0.02) as share:
        change_bytes(share)


@settings(max_examples=150, deadline=None)
@given(
    edits=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=2),
    cut=st.integers(0, 10**6) | st.none(),
    name=st.sampled_from(sorted(SAMPLES)),
)
def change_bytes(share: Share, edits: list[tuple[int, int]], cut: int | None, name: str) -> None:
    data = bytearray(GLBS[name])
    for place, value in edits:
        data[place % len(data)] = value
    read_or_refuse(bytes(data if cut is None else data[: cut % len(data)]), True, share)


GLBS = {name: build().glb(indent=None) for name, build in SAMPLES.items()}


def test_deep_and_huge_json() -> None:
    start = b'{"asset":{"version":"2.0"},"extras":'
    for text in (
        b"[" * 200_000,
        b'{"a":' * 100_000,
        b"9" * 100_000,
        b"NaN",
        b"1e999",
        b'"\xff"',
        b'{"a":1,"a":2}',
    ):
        with pytest.raises(FormatError):
            parse_gltf(start + text + b"}", HERE)


def refused(change: Any, pattern: str, build: Any = cube) -> None:
    sample: Sample = build()
    change(sample.tree)
    with pytest.raises(FormatError, match=pattern):
        parse_glb(sample.glb(), HERE)


def test_each_mistake_is_named() -> None:
    def put(*path: Any, value: Any) -> Any:
        def change(tree: Any) -> None:
            for key in path[:-1]:
                tree = tree[key]
            tree[path[-1]] = value

        return change

    refused(put("accessors", 0, "count", value=9), "accessor 0 needs more than the 96 bytes")
    refused(put("accessors", 0, "count", value=4), "index .* expected an index below 4")
    refused(put("accessors", 0, "componentType", value=5123), "KHR_mesh_quantization")
    refused(put("accessors", 0, "bufferView", value=7), "expected an index below 2")
    refused(put("bufferViews", 0, "byteLength", value=10**6), "ends at byte")
    refused(put("bufferViews", 0, "byteStride", value=8), "stride of 8 bytes")
    refused(put("meshes", 0, "primitives", 0, "mode", value=1), "no triangles")
    refused(put("nodes", 0, "scale", value=[0, 1, 1]), "no triangles")
    refused(put("nodes", 0, "rotation", value=[0, 0, 0, "1"]), "expected 4 finite numbers")
    refused(put("nodes", 0, "matrix", value=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2]), "not affine")
    refused(put("nodes", 0, "matrix", value=[0.5] * 16), "not affine")
    refused(put("nodes", 0, "children", value=[0]), "node 0")
    refused(put("nodes", 1, "children", value=[3]), "child twice|a child of", instances)
    refused(put("scenes", 0, "nodes", value=[]), "no triangles")
    compressed = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    refused(
        put("meshes", 0, "primitives", 0, "extensions", value=compressed), "mesh 0, primitive 0.*Draco stream"
    )
    packed = {"buffer": 0, "byteLength": 96, "byteStride": 12, "count": 8, "mode": "ATTRIBUTES"}
    extensions = {"EXT_meshopt_compression": packed}
    refused(
        put("bufferViews", 0, "extensions", value=extensions), "bufferView 0: a meshopt stream .* header byte"
    )
    extensions = {"EXT_meshopt_compression": packed | {"mode": "LINES"}}
    refused(
        put("bufferViews", 0, "extensions", value=extensions), "bufferView 0 is compressed with mode 'LINES'"
    )
    extensions = {"KHR_meshopt_compression": packed | {"count": 2**40}}
    refused(put("bufferViews", 0, "extensions", value=extensions), "claims to unpack to")


@pytest.mark.parametrize(
    "uri",
    [
        *("../up.bin", "/etc/passwd", "http://a/b.bin", "a/../../b", "..%2Fb.bin", "c:\\b", ""),
        *("..\\up.bin", "a\\..\\..\\b.bin", "%5C..%5Cb.bin", "\\\\host\\share\\b.bin", "\\b.bin", "a/..\\b"),
    ],
)
def test_buffers_outside_the_folder_are_refused(uri: str) -> None:
    with pytest.raises(FormatError, match="not a file inside"):
        parse_gltf(cube().json(uri=uri), HERE)


def test_missing_buffer_is_named(tmp_path: Path) -> None:
    with pytest.raises(
        FormatError, match=r"the buffer gone\.bin that model\.gltf refers to is not beside it"
    ):
        parse_gltf(cube().json(uri="gone.bin"), tmp_path / "model.gltf")


def test_not_finite_position_is_named() -> None:
    sample = rich()
    sample.blob[12:16] = np.float32(np.nan).tobytes()
    with pytest.raises(FormatError, match="accessor 0, row 1"):
        parse_glb(sample.glb(), HERE)


def test_many_showings_are_bounded() -> None:
    sample = cube()
    sample.tree["accessors"][0] = {"componentType": 5126, "type": "VEC3", "count": 3_000_000}
    for _ in range(20):
        sample.node(mesh=0)
    with pytest.raises(FormatError, match="more than"):
        parse_glb(sample.glb(), HERE)


_PROBE = """
import resource, sys
from pathlib import Path
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
import numpy as np
from meshmark.errors import FormatError
from meshmark.io.gltf.parse import parse_glb, parse_gltf
from meshmark.io.threemf.parse import parse_3mf
read = {".glb": parse_glb, ".gltf": parse_gltf, ".3mf": parse_3mf}
fine = 0
for name in sys.argv[1:]:
    path = Path(name)
    data = path.read_bytes()
    try:
        document = read[path.suffix.lower()](data, path)
    except FormatError as error:
        assert str(error) and "\\n" not in str(error), name
        continue
    assert document.patched(document.vertices, path.name)[path.name] == data, name
    vertices = document.vertices * 1.001
    assert np.isfinite(document.conform(vertices)).all(), name
    document.patched(vertices, path.name)
    fine += 1
print(fine)
"""


@pytest.mark.shared
def test_hostile_files_are_read_or_refused(shared_data: Path) -> None:
    kinds = (".glb", ".gltf", ".3mf")
    paths = [
        str(path) for path in sorted((shared_data / "hostile").rglob("*")) if path.suffix.lower() in kinds
    ]
    assert len(paths) > 100
    done = subprocess.run(
        [sys.executable, "-c", _PROBE, *paths], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) >= 20
