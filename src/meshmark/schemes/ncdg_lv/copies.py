"""A mark of a scene that shows meshes several times: it goes into one showing of each, the others follow."""

from __future__ import annotations

from dataclasses import replace
from math import inf, log10

import numpy as np

from meshmark.io.distinct import Distinct
from meshmark.schemes.ncdg_lv.embedding import diagonal_of, displacement_rms
from meshmark.schemes.ncdg_lv.results import Embedding

__all__ = ["as_scene"]


def as_scene(result: Embedding, once: Distinct) -> Embedding:
    """Return the embedding into `once.mesh` as one into the scene it was taken from."""
    marked = once.whole(result.mesh.vertices)
    diagonal = diagonal_of(once.scene)
    rms = displacement_rms(once.scene, marked) / diagonal
    largest = float(np.linalg.norm(marked.vertices - once.scene.vertices, axis=1).max()) / diagonal
    return replace(
        result,
        mesh=marked,
        vertices=len(marked.vertices),
        faces=len(marked.faces),
        rms_over_diagonal=rms,
        max_over_diagonal=largest,
        psnr_db=-20.0 * log10(rms) if rms > 0.0 else inf,
    )
