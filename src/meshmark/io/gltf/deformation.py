"""How far a viewer moves the points of a glTF mesh from where they are stored: morph targets and skins.

glTF 2.0, sections 3.7.2.2 (morph targets) and 3.7.3.3 (skinned mesh attributes).
"""

from __future__ import annotations

from itertools import count

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.node_tree import Nodes, Showing
from meshmark.io.gltf.scene import Primitive
from meshmark.io.gltf.schema import numbers, objects, reference
from meshmark.io.gltf.skin import joint_matrices
from meshmark.mesh import FloatArray, IntArray

__all__ = ["morph_displacement", "morphs", "skin_displacement"]

# Weights of joints that do not add up to 1 are made to by some viewers only; rounding to 8 bits is less than this.
_WEIGHTS_WITHIN = 0.05


def morphs(container: Container, mesh: int) -> bool:
    """Return whether a mesh has morph targets that move points."""
    return any(
        "POSITION" in target
        for item in objects(container.tables["meshes"][mesh], "primitives")
        for target in objects(item, "targets")
    )


def morph_displacement(container: Container, showing: Showing, primitive: Primitive) -> float:
    """Return the largest displacement of a point by the weights that a file sets, in scene units."""
    targets = objects(primitive.item, "targets")
    weights = _weights(container, showing, len(targets))
    if not targets:
        return 0.0
    used = np.unique(primitive.faces)
    total: FloatArray = np.zeros((len(used), 3))
    for target, weight in zip(targets, weights, strict=True):
        index = reference(target, "POSITION", "morph target", container.tables["accessors"])
        if weight and index is not None:
            rows = open_accessor(container, index).values(container.blob)
            total += weight * _rows(rows, used, 3)
    moved = total @ showing.affine.linear.T
    return float(np.sqrt((moved**2).sum(axis=1)).max(initial=0.0))


def _weights(container: Container, showing: Showing, number: int) -> list[float]:
    """Return the weights of a showing's morph targets: its node's, else its mesh's, else none."""
    node = {} if showing.node is None else container.tables["nodes"][showing.node]
    holder = node if "weights" in node else container.tables["meshes"][showing.mesh]
    return numbers(holder, "weights", "morph weights", [0.0] * number)


def skin_displacement(
    container: Container, nodes: Nodes, showing: Showing, primitive: Primitive, stored: FloatArray
) -> float:
    """Return how far the joints of a skin take a point from where the mesh at rest has it, in scene units.

    stored: (s, 3) positions of the primitive's accessor. Infinite where weights do not add up to 1, which viewers
    answer in different ways.
    """
    if showing.skin is None or "JOINTS_0" not in primitive.attributes:
        return 0.0
    used = np.unique(primitive.faces)
    joints, weights = _influences(container, primitive, used)
    sums = weights.sum(axis=1)
    if (np.abs(sums - 1.0) > _WEIGHTS_WITHIN).any():
        return float("inf")
    matrices = joint_matrices(container, showing.skin, nodes.world)
    if joints.max(initial=0) >= len(matrices):
        raise FormatError(
            f"skin {showing.skin} has {len(matrices)} joints, a vertex names joint {joints.max()}"
        )
    linear = np.stack([matrix.linear for matrix in matrices])
    offset = np.stack([matrix.offset for matrix in matrices])
    points = stored[used]
    shown = np.zeros_like(points)
    for joint, weight in zip(joints.T, (weights / sums[:, None]).T, strict=True):
        moved = np.einsum("nij,nj->ni", linear[joint], points) + offset[joint]
        shown += weight[:, None] * moved
    rest = showing.affine(points)
    return float(np.sqrt(((shown - rest) ** 2).sum(axis=1)).max(initial=0.0))


def _influences(container: Container, primitive: Primitive, used: IntArray) -> tuple[IntArray, FloatArray]:
    joints, weights = [], []
    for group in count():
        names = (f"JOINTS_{group}", f"WEIGHTS_{group}")
        if not all(name in primitive.attributes for name in names):
            break
        tables = [open_accessor(container, primitive.attributes[name]) for name in names]
        joints.append(_rows(tables[0].values(container.blob), used, 4).astype(np.int64))
        weights.append(_rows(tables[1].values(container.blob), used, 4))
    if not joints:
        raise FormatError("a skinned primitive has JOINTS_0 and no WEIGHTS_0, expected both")
    return np.concatenate(joints, axis=1), np.concatenate(weights, axis=1)


def _rows(table: FloatArray, used: IntArray, width: int) -> FloatArray:
    if table.shape[1] != width or len(table) <= used.max(initial=0):
        raise FormatError("an attribute has another number of rows than the positions it belongs to")
    return np.asarray(table[used])
