"""Scenes made for tests in which one mesh is shown several times."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from meshmark.io import read_mesh, write_mesh
from meshmark.mesh import FloatArray, IntArray, Mesh
from tests.io.gltf_samples import Sample
from tests.io.threemf_samples import model, package

Shape = tuple[FloatArray, IntArray]


def placed(shift: Sequence[float], seed: int, scale: float = 1.0, mirror: bool = False) -> FloatArray:
    """Return a (4, 4) matrix that turns by chance, resizes, and moves."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.random(random_state=seed).as_matrix() * scale
    if mirror:
        matrix[:3, 0] *= -1.0
    matrix[:3, 3] = shift
    return matrix


def glb(path: Path, shapes: Sequence[Shape], nodes: Sequence[tuple[int, FloatArray]]) -> Mesh:
    """Write and read a GLB with a node for each (shape, matrix)."""
    sample = Sample()
    for points, faces in shapes:
        sample.mesh(sample.array(points.astype("f4"), bounds=True), sample.array(faces.ravel(), "u4"))
    for number, matrix in nodes:
        sample.node(mesh=number, matrix=matrix.T.ravel().tolist())
    path.write_bytes(sample.glb(extra_chunk=False))
    return read_mesh(path)


def threemf(path: Path, shape: Shape, matrices: Sequence[FloatArray]) -> Mesh:
    """Write and read a 3MF with one object, shown by a component for the first matrix and items for the others."""
    points = "".join(f'<vertex x="{x:.6f}" y="{y:.6f}" z="{z:.6f}"/>' for x, y, z in shape[0])
    corners = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in shape[1])
    first, *others = [" ".join(f"{x:.9g}" for x in matrix[:3].T.ravel()) for matrix in matrices]
    resources = (
        f'<object id="1" type="model"><mesh><vertices>{points}</vertices><triangles>{corners}</triangles></mesh>'
        f'</object><object id="2" type="model"><components><component objectid="1" transform="{first}"/>'
        "</components></object>"
    )
    build = '<item objectid="2"/>' + "".join(f'<item objectid="1" transform="{text}"/>' for text in others)
    path.write_bytes(package(model(resources, build)))
    return read_mesh(path)


def baked(mesh: Mesh, path: Path, **options: Any) -> Mesh:
    """Write a mesh to a format without copies, and read it."""
    write_mesh(mesh, path, **options)
    return read_mesh(path)
