"""What the animations of a glTF move of what it shows."""

from __future__ import annotations

from meshmark.errors import FormatError
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.deformation import morphs
from meshmark.io.gltf.node_tree import Nodes
from meshmark.io.gltf.schema import Json, objects, reference, references

__all__ = ["animated"]

_ALL = frozenset(("morph_animation", "skeletal_animation", "node_animation", "pointer_animation"))


def animated(container: Container, nodes: Nodes) -> frozenset[str]:
    """Return the kinds of deviations, as in `document.KINDS`, that play when the animations do.

    Of animations that break the format, all kinds: viewers answer them in different ways.
    """
    try:
        return _animated(container, nodes)
    except FormatError:
        return _ALL


def _animated(container: Container, nodes: Nodes) -> frozenset[str]:
    channels = [item for table in container.tables["animations"] for item in objects(table, "channels")]
    if not channels:
        return frozenset()
    joints = nodes.above(joint for skin in _skins(container, nodes) for joint in skin)
    movable = nodes.above(each.node for each in nodes.showings if each.skin is None)
    morphing = frozenset(each.node for each in nodes.showings if morphs(container, each.mesh))
    return frozenset(filter(None, (_kind(container, item, joints, movable, morphing) for item in channels)))


def _kind(
    container: Container,
    item: Json,
    joints: frozenset[int],
    movable: frozenset[int],
    morphing: frozenset[int | None],
) -> str | None:
    target = item.get("target")
    if not isinstance(target, dict):
        return None
    if target.get("path") == "pointer":
        return "pointer_animation"
    node = reference(target, "node", "animation", container.tables["nodes"])
    if target.get("path") == "weights":
        return "morph_animation" if node in morphing else None
    if node in joints:
        return "skeletal_animation"
    return "node_animation" if node in movable else None


def _skins(container: Container, nodes: Nodes) -> list[list[int]]:
    skins = container.tables["skins"]
    used = sorted({each.skin for each in nodes.showings if each.skin is not None})
    return [
        references(skins[number], "joints", f"skin {number}", container.tables["nodes"]) for number in used
    ]
