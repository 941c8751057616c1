"""The id in a scene that shows meshes several times, into the copies alone where it does not fit elsewhere."""

from __future__ import annotations

from dataclasses import replace

from meshmark.coding.keys import Key
from meshmark.coding.message import bits_of
from meshmark.errors import CapacityError
from meshmark.mesh import Mesh
from meshmark.ownership.embedding import Owned, embed
from meshmark.scene.distinct import scene_of

__all__ = ["embed_repeated"]


def embed_repeated(
    mesh: Mesh, key: Key, *, id: int, strength: str = "standard", reserve: float = 0.0
) -> Owned:
    """Embed the ownership layer, or else into that part of the mesh which its scene shows more than once.

    Parameters
    ----------
    mesh : Mesh
        Any, or one that stands for the copies of its scene.
    id : int
        Of 64 or 32 bits, or `PRESENCE`, as `coding.message` counts them.
    key, strength, reserve
        As in `ownership.embedding.embed`, which also raises what this raises.

    Returns
    -------
    Owned
    """
    bits = bits_of(id)
    try:
        return embed(mesh, key, id=id, bits=bits, strength=strength, reserve=reserve)
    except CapacityError:
        scene = scene_of(mesh)
        piece = None if scene is None else scene.repeated(mesh)
        if piece is None:
            raise
        found = embed(piece.mesh, key, id=id, bits=bits, strength=strength, reserve=reserve)
        mark = replace(found.mark, repeated_only=True, parts=())
        return Owned(mesh=piece.back(found.mesh.vertices), mark=mark)
