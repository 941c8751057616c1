"""What a small file may ask for: the triangles of a scene, and the memory that reading a compressed file takes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from meshmark.errors import FormatError
from meshmark.io.gltf import scene as gltf_scene
from meshmark.io.gltf.parse import parse_glb
from tests.io.gltf_samples import Sample, cube

HERE = Path("nowhere/model.glb")
MESHOPT = "EXT_meshopt_compression"
# Reads one file; prints the peak memory in MB, the number of triangles, and what was said.
READER = """
import sys
from pathlib import Path
from meshmark.errors import FormatError
from meshmark.io import read_mesh
triangles, said = 0, ""
try:
    triangles = len(read_mesh(sys.argv[1]).faces)
except FormatError as error:
    said = str(error)
# Not getrusage: that starts with what the process that started this one had.
peak = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
print(int(peak.split()[1]) // 1024, triangles, said)
"""


def equal_rows(count: int, stride: int) -> bytes:
    """Return a meshopt stream of zeros, which takes a byte for every 256 rows of 4 bytes."""
    block = min(8192 // stride // 16 * 16, 256)
    return b"\xa1" + b"\xaa" * (stride // 4) * -(-count // block) + bytes(max(24, stride + stride // 4))


def zeros(points: int, triangles: int, primitives: int) -> Sample:
    """Return a compressed sheet of zeros; `primitives` of `triangles` each show it."""
    sample, start = Sample(), 0
    for count, stride, component, kind in ((points, 12, 5126, "VEC3"), (3 * triangles, 4, 5125, "SCALAR")):
        stream = equal_rows(count, stride)
        record = {
            "buffer": 0,
            "byteOffset": len(sample.blob),
            "byteLength": len(stream),
            "mode": "ATTRIBUTES",
        }
        record |= {"count": count, "byteStride": stride}
        sample.blob += stream + bytes(-len(stream) % 4)
        given = {"byteStride": 12} if kind == "VEC3" else {}
        view = sample.put(
            "bufferViews",
            buffer=1,
            byteOffset=start,
            byteLength=count * stride,
            extensions={MESHOPT: record},
            **given,
        )
        sample.put("accessors", bufferView=view, componentType=component, count=count, type=kind)
        start += count * stride
    sample.put("meshes", primitives=[{"attributes": {"POSITION": 0}, "indices": 1}] * primitives)
    sample.put("nodes", mesh=0)
    sample.tree["buffers"] = [
        {"byteLength": len(sample.blob)},
        {"byteLength": start, "extensions": {MESHOPT: {"fallback": True}}},
    ]
    sample.tree["extensionsUsed"] = sample.tree["extensionsRequired"] = [MESHOPT]
    return sample


def read_apart(data: bytes, path: Path) -> tuple[int, int, str]:
    """Return peak memory in MB, triangles, and the sentence of a reader of its own."""
    path.write_bytes(data)
    done = subprocess.run(
        [sys.executable, "-c", READER, str(path)], capture_output=True, text=True, check=True
    )
    memory, triangles, said = done.stdout.split(" ", 2)
    return int(memory), int(triangles), said.strip()


def test_the_most_that_is_read_of_a_compressed_file_takes_less_than_a_gigabyte(tmp_path: Path) -> None:
    memory, triangles, said = read_apart(zeros(2_500_000, 100_000, 50).glb(), tmp_path / "most.glb")
    assert (triangles, said) == (5_000_000, "")
    assert 200 < memory < 1024


@pytest.mark.parametrize(
    ("points", "primitives"), [(2_600_000, 1), (1000, 51), (1000, 5000)], ids=["points", "one", "many"]
)
def test_a_compressed_file_that_shows_more_is_refused_before_its_triangles_are_read(
    tmp_path: Path, points: int, primitives: int
) -> None:
    memory, _, said = read_apart(zeros(points, 100_000, primitives).glb(), tmp_path / "large.glb")
    assert said.endswith(
        "large.glb: the scene of a compressed file shows more than 2,500,000 points or 5,000,000 triangles: "
        "uncompress it with another tool first"
    )
    assert memory < 400


def test_primitives_that_repeat_their_triangles_are_counted_before_any_is_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sample = cube()
    sample.tree["meshes"][0]["primitives"] *= 3
    assert len(parse_glb(sample.glb(), HERE).faces) == 36
    monkeypatch.setattr(gltf_scene, "_MOST", (1000, 35))
    monkeypatch.setattr(gltf_scene, "primitives_of", lambda *_: pytest.fail("the triangles were read"))
    with pytest.raises(FormatError, match="the scene shows more than 1,000 points or 35 triangles"):
        parse_glb(sample.glb(), HERE)
