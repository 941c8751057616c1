"""Real and hostile files of the shared data: read and kept byte for byte, or refused in one sentence."""

from __future__ import annotations

import json
import lzma
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from meshmark.io import read_mesh, write_mesh
from tests.counting import some

pytestmark = pytest.mark.shared
SUFFIXES = {".off", ".obj", ".ply", ".stl"}
SECONDS, BYTES = 60, 3 << 30

# Reads every file named on standard input, saves it unmoved, and prints what happened as JSON lines.
CHILD = """
import json, sys, tempfile
from pathlib import Path
from meshmark.errors import MeshmarkError
from meshmark.io import read_mesh, write_mesh
for line in sys.stdin:
    path = Path(line.rstrip("\\n"))
    with tempfile.TemporaryDirectory() as folder:
        try:
            mesh = read_mesh(path)
            out = write_mesh(mesh, Path(folder) / path.name).files[0]
            result = "same" if out.read_bytes() == path.read_bytes() else "other bytes"
        except MeshmarkError as error:
            result = "refused " + str(error)
    print(json.dumps([str(path), result]), flush=True)
"""


def test_hostile_files(shared_data: Path) -> None:
    files = [path for path in sorted((shared_data / "hostile").rglob("*")) if path.suffix.lower() in SUFFIXES]
    done = subprocess.run(
        [sys.executable, "-c", CHILD],
        input="\n".join(map(str, files)),
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES)),
    )
    assert done.returncode == 0, done.stderr[-2000:]
    results = dict(map(json.loads, done.stdout.splitlines()))
    assert set(results) == set(map(str, files))
    for path, result in some(results.items()):
        assert result == "same" or result.startswith(f"refused {path}"), (path, result)
        assert "\n" not in result
    assert sum(result == "same" for result in results.values()) >= 140


def packed_models(shared_data: Path) -> list[Path]:
    models = sorted((shared_data / "models").rglob("*.xz")) + sorted(
        (shared_data / "msdm2").rglob("*.obj.xz")
    )
    return models[::4] + sorted((shared_data / "psb").rglob("*.xz"))[::40]


def test_models_are_kept_byte_for_byte_and_patched(shared_data: Path, tmp_path: Path) -> None:
    for path in some(packed_models(shared_data)):
        plain = tmp_path / path.stem
        plain.write_bytes(lzma.decompress(path.read_bytes()))
        mesh = read_mesh(plain)
        out = tmp_path / f"out{plain.suffix}"
        write_mesh(mesh, out)
        assert out.read_bytes() == plain.read_bytes(), path
        assert mesh.document is not None
        moved = mesh.vertices + 1e-4 * np.random.default_rng(1).standard_normal(mesh.vertices.shape)
        write_mesh(mesh.with_vertices(moved), out)
        again = read_mesh(out)
        np.testing.assert_array_equal(again.vertices, mesh.document.conform(moved))
        np.testing.assert_array_equal(again.faces, mesh.faces)
        plain.unlink()


def test_textured_obj(shared_data: Path, tmp_path: Path) -> None:
    path = shared_data / "textured" / "spot.obj"
    mesh = read_mesh(path)
    moved = mesh.with_vertices(mesh.vertices * 1.01 + 0.001)
    write_mesh(moved, tmp_path / "spot.obj")
    old, new = path.read_text().splitlines(), (tmp_path / "spot.obj").read_text().splitlines()
    assert [line for line in new if not line.startswith("v ")] == [
        line for line in old if not line.startswith("v ")
    ]
    written = np.array([line.split()[1:] for line in new if line.startswith("v ")], dtype=float)
    np.testing.assert_allclose(written, moved.vertices, atol=1e-6)
