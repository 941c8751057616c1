"""A mark of a scene that shows meshes several times: it goes into one showing of each, the others follow."""

from __future__ import annotations

from dataclasses import replace
from math import inf, log10

import numpy as np

from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.mesh import Mesh
from meshmark.ownership.embedding import diagonal_of, displacement_rms, embed
from meshmark.ownership.results import Embedding
from meshmark.scene.distinct import Distinct, scene_of

__all__ = ["as_scene", "embed_repeated"]


def embed_repeated(
    mesh: Mesh, key: Key, *, id: int, strength: str = "standard", reserve: float = 0.0
) -> Embedding:
    """Embed as `embedding.embed` does, or else into that part of the mesh which its scene shows more than once.

    mesh: any, or one that stands for the copies of its scene. Raises as `embedding.embed` does.
    """
    try:
        return embed(mesh, key, id=id, strength=strength, reserve=reserve)
    except CapacityError:
        scene = scene_of(mesh)
        piece = None if scene is None else scene.repeated(mesh)
        if piece is None:
            raise
        result = embed(piece.mesh, key, id=id, strength=strength, reserve=reserve)
        return replace(_measured(result, mesh, piece.back(result.mesh.vertices)), repeated_only=True)


def as_scene(result: Embedding, once: Distinct) -> Embedding:
    """Return the embedding into `once.mesh` as one into the scene it was taken from."""
    return _measured(result, once.scene, once.whole(result.mesh.vertices))


def _measured(result: Embedding, original: Mesh, marked: Mesh) -> Embedding:
    diagonal = diagonal_of(original)
    rms = displacement_rms(original, marked) / diagonal
    largest = float(np.linalg.norm(marked.vertices - original.vertices, axis=1).max()) / diagonal
    return replace(
        result,
        mesh=marked,
        vertices=len(marked.vertices),
        faces=len(marked.faces),
        rms_over_diagonal=rms,
        max_over_diagonal=largest,
        psnr_db=-20.0 * log10(rms) if rms > 0.0 else inf,
    )
