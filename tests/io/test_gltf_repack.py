"""Saved compressed again: with Draco, positions on a fine grid, all else as it was; meshopt is refused by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.io import check_recompression, read_mesh, write_mesh
from meshmark.io.gltf.accessor import open_accessor
from meshmark.mesh import Mesh
from tests.io.compressed_samples import draco_grid, with_meshopt
from tests.io.gltf_samples import SAMPLES, Sample


def saved(sample: Sample, folder: Path, ending: str = ".glb") -> tuple[Mesh, Mesh]:
    """Return the sample as it is read with every point moved, and what a recompressed save of that gives."""
    source, out = folder / f"in{ending}", folder / f"out{ending}"
    if ending == ".glb":
        source.write_bytes(sample.glb())
    else:
        (folder / "in.bin").write_bytes(sample.blob)
        source.write_bytes(sample.json(uri="in.bin"))
    mesh = read_mesh(source)
    assert mesh.document is not None
    moved = mesh.with_vertices(
        mesh.document.conform(mesh.vertices + 0.01 * np.sin(9 * mesh.vertices[:, ::-1]))
    )
    report = write_mesh(moved, out, recompress=True)
    assert report.decompressed == ()
    again = read_mesh(out)
    assert again.document is not None
    assert again.document.summary()["compression"] == ["KHR_draco_mesh_compression"]
    return moved, again


def corners(mesh: Mesh, *names: str) -> Any:
    """Return per triangle its corners with their attributes, in an order of their own."""
    container = mesh.document.document.container  # type: ignore[union-attr]
    item = container.tables["meshes"][0]["primitives"][0]
    found = [mesh.vertices.round(4)]
    found += [open_accessor(container, item["attributes"][name]).values(container.blob) for name in names]
    rows = np.hstack(found)[mesh.faces]
    rows = np.array([face[np.lexsort(face.T)] for face in rows]).reshape(len(rows), -1)
    return rows[np.lexsort(rows.T)]


@pytest.mark.parametrize("ending", [".glb", ".gltf"])
def test_surface_and_attributes_come_back(tmp_path: Path, ending: str) -> None:
    sample = draco_grid()
    moved, again = saved(sample, tmp_path, ending)
    assert np.allclose(corners(moved, "NORMAL", "_JOINT"), corners(again, "NORMAL", "_JOINT"), atol=2e-4)
    grid = np.ptp(moved.vertices, axis=0).max() / 2**24
    nearest = np.abs(moved.vertices[:, None] - again.vertices[None]).max(axis=2).min(axis=1)
    assert nearest.max() <= 2 * grid
    tree = again.document.document.container.tree  # type: ignore[union-attr]
    assert tree["nodes"] == sample.tree["nodes"]


def test_the_stream_takes_the_place_of_the_old_one(tmp_path: Path) -> None:
    saved(draco_grid(40), tmp_path)
    plain = tmp_path / "plain.glb"
    mesh = read_mesh(tmp_path / "in.glb")
    write_mesh(mesh.with_vertices(mesh.vertices + 0.01), plain)
    assert (tmp_path / "out.glb").stat().st_size < 0.8 * plain.stat().st_size
    compressed = read_mesh(tmp_path / "out.glb").document.document.compressed  # type: ignore[union-attr]
    assert len(compressed.tables["bufferViews"]) == 1


def test_points_stay_in_their_order_where_morph_targets_count_them(tmp_path: Path) -> None:
    sample = draco_grid()
    count = sample.tree["accessors"][0]["count"]
    offsets = np.random.default_rng(1).random((count, 3)).astype("<f4")
    sample.tree["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": sample.array(offsets, bounds=True)}]
    moved, again = saved(sample, tmp_path)
    assert np.allclose(moved.vertices, again.vertices, atol=1e-5)
    container = again.document.document.container  # type: ignore[union-attr]
    target = container.tables["meshes"][0]["primitives"][0]["targets"][0]["POSITION"]
    assert np.array_equal(open_accessor(container, target).raw(container.blob), offsets)


def test_seams_between_primitives_stay_closed(tmp_path: Path) -> None:
    sample = draco_grid()
    moved, _ = saved(sample, tmp_path)
    other = draco_grid(12)  # the same sheet again, half of it: other extents, common points
    shift = len(sample.tree["accessors"])
    view = sample.view(bytes(other.blob))
    item = other.tree["meshes"][0]["primitives"][0]
    sample.tree["accessors"] += other.tree["accessors"]
    item["indices"] += shift
    item["attributes"] = {name: number + shift for name, number in item["attributes"].items()}
    item["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = view
    sample.tree["meshes"][0]["primitives"].append(item)
    _, again = saved(sample, tmp_path)
    half = len(again.vertices) // 2
    first, second = (np.unique(part, axis=0) for part in (again.vertices[:half], again.vertices[half:]))
    assert len(first) == len(np.unique(moved.vertices, axis=0))
    assert np.array_equal(first, second)


def test_what_cannot_be_compressed_as_it_was_is_refused(tmp_path: Path) -> None:
    (tmp_path / "m.glb").write_bytes(with_meshopt(SAMPLES["cube"]()).glb())
    (tmp_path / "p.glb").write_bytes(SAMPLES["cube"]().glb())
    (tmp_path / "d.glb").write_bytes(draco_grid().glb())
    before = set(tmp_path.iterdir())
    for name, out, says in (
        ("m.glb", "out.glb", "no encoder for EXT_meshopt_compression"),
        ("p.glb", "out.glb", "p.glb is not compressed"),
        ("d.glb", "out.obj", "written in another format"),
    ):
        mesh = read_mesh(tmp_path / name)
        with pytest.raises(InputError, match=says):
            check_recompression(mesh, tmp_path / out)
        with pytest.raises(InputError, match=says):
            write_mesh(mesh.with_vertices(mesh.vertices * 1.01), tmp_path / out, recompress=True)
    assert set(tmp_path.iterdir()) == before
