"""Models that are marked once for all tests of a process; tests only read them."""

from __future__ import annotations

from functools import cache

import numpy as np

from meshmark.marking import Embedding, embed
from meshmark.mesh import Mesh
from tests.keys import ID, KEY, OTHER_ID
from tests.shapes import pebble

__all__ = ["marked_pebble", "mosaic_of_pebbles", "other_copy"]


@cache
def marked_pebble(across: int = 58, **options: str) -> Embedding:
    """Return the pebble, of 1,626 vertices by default, with `ID` under `KEY`; options: as `embed` takes them."""
    return embed(Mesh(*pebble(across)), KEY, id=ID, **options)


@cache
def other_copy(across: int = 58) -> Embedding:
    """Return the pebble with authentication marks of `OTHER_ID` under `KEY`."""
    return embed(Mesh(*pebble(across)), KEY, id=OTHER_ID, layers="authentication", payload="none")


def mosaic_of_pebbles() -> Mesh:
    """Return a pebble of which the vertices beyond the median x are those of the other copy."""
    vertices = marked_pebble().mesh.vertices
    beyond = vertices[:, :1] > np.median(vertices[:, 0])
    return Mesh(np.where(beyond, other_copy().mesh.vertices, vertices), marked_pebble().mesh.faces)
