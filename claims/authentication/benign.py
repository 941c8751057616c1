"""False alarms: benign operations leave a model authentic; the layer alone is not seen."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import meshmark as mm
from claims.authentication.figures import Row
from claims.authentication.subjects import KEY, Subject
from claims.marks import benign_operations
from meshmark.geometry.areas import vertex_normals
from meshmark.mesh import Mesh

__all__ = ["measure"]


def measure(subject: Subject, _draws: int | None) -> Iterator[Row]:
    """Yield the layer's PSNR, and whether each operation leaves the model authentic."""
    yield Row("PSNR of the layer alone", subject.name, "", subject.upper.psnr_db)
    mesh = subject.marked.mesh
    for name, changed in [*benign_operations(mesh, subject.rng("benign")), *_attributes(mesh)]:
        found = mm.authenticate(changed, KEY)
        yield Row("authentic after a benign operation", subject.name, name, found.verdict == "authentic")
    rounded = mm.authenticate(mm.ATTACKS["file_off"](mesh, 1, subject.rng("digits")), KEY)
    yield Row("authentic after six significant digits", subject.name, "", rounded.verdict == "authentic")


def _attributes(mesh: Mesh) -> Iterator[tuple[str, Mesh]]:
    """Yield the model with normals, colours and texture coordinates, converted with them, and stripped of them."""
    with tempfile.TemporaryDirectory(prefix="meshmark-") as name:
        folder = Path(name)
        _write_dressed(mesh, folder / "dressed.obj")
        dressed = mm.read_mesh(folder / "dressed.obj")
        yield "normals, UVs, colours added", dressed
        for kind in ("ply", "glb"):
            mm.write_mesh(dressed, folder / f"dressed.{kind}")
            yield f"added, to {kind}", mm.read_mesh(folder / f"dressed.{kind}")
        mm.write_mesh(mm.read_mesh(folder / "dressed.glb"), folder / "plain.stl")
        yield "stripped again, to stl", mm.read_mesh(folder / "plain.stl")


def _write_dressed(mesh: Mesh, path: Path) -> None:
    """Write an OBJ with six decimals, as most programs do; every face has texture coordinates of its own."""
    low, size = mesh.vertices.min(axis=0), np.ptp(mesh.vertices, axis=0)
    colours = (mesh.vertices - low) / np.where(size > 0.0, size, 1.0)
    normals = vertex_normals(mesh.vertices, mesh.faces)
    corners = np.arange(mesh.faces.size).reshape(-1, 3) + 1
    with path.open("w") as file:
        np.savetxt(file, np.hstack([mesh.vertices, colours]), "v %.6f %.6f %.6f %.3f %.3f %.3f")
        np.savetxt(file, np.random.default_rng(1).random((mesh.faces.size, 2)), "vt %.4f %.4f")
        np.savetxt(file, normals, "vn %.4f %.4f %.4f")
        names = np.stack([mesh.faces + 1, corners, mesh.faces + 1], axis=2).reshape(-1, 9)
        np.savetxt(file, names, "f %d/%d/%d %d/%d/%d %d/%d/%d")
