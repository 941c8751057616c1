"""Where a skinned mesh stands in the scene.

glTF 2.0, section 3.7.3.3: the transform of the node is ignored, each vertex follows its joints, whose matrices are
(scene transform of the joint) x (inverse bind matrix). A model at rest has one and the same matrix at all joints:
the scale and turn between bind coordinates and the scene. In another pose they differ, and their mean is taken.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.schema import reference, references
from meshmark.io.placement import Affine

__all__ = ["joint_matrices", "skin_placement"]


def skin_placement(container: Container, number: int, world: Mapping[int, Affine]) -> Affine:
    """Return the mean joint matrix of a skin; `world` has the scene transform of every node shown."""
    joints, binds = _bound(container, number)
    shown = [world[joint].after(bind) for joint, bind in zip(joints, binds, strict=True) if joint in world]
    if not shown:
        return Affine.identity()
    mean = Affine(
        np.mean([matrix.linear for matrix in shown], axis=0),
        np.mean([matrix.offset for matrix in shown], axis=0),
    )
    return mean if mean.is_usable else Affine.identity()


def joint_matrices(container: Container, number: int, world: Mapping[int, Affine]) -> list[Affine]:
    """Return the matrix of each joint of a skin; a joint that no scene shows stands at the origin."""
    joints, binds = _bound(container, number)
    nowhere = Affine.identity()
    return [world.get(joint, nowhere).after(bind) for joint, bind in zip(joints, binds, strict=True)]


def _bound(container: Container, number: int) -> tuple[list[int], list[Affine]]:
    """Return the joints of a skin and their inverse bind matrices."""
    tables = container.tables
    skin, where = tables["skins"][number], f"skin {number}"
    joints = references(skin, "joints", where, tables["nodes"])
    index = reference(skin, "inverseBindMatrices", where, tables["accessors"])
    if index is None:
        return joints, [Affine.identity()] * len(joints)
    accessor = open_accessor(container, index)
    if accessor.width != 16 or accessor.count < len(joints):
        raise FormatError(f"{where}: accessor {index} holds no inverse bind matrix for every joint")
    matrices = accessor.values(container.blob)[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    return joints, [Affine(matrix[:3, :3], matrix[:3, 3]) for matrix in matrices]
