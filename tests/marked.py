"""Models that are marked once for all tests of a process; tests only read them."""

from __future__ import annotations

from functools import cache

from meshmark.marking import Embedding, embed
from meshmark.mesh import Mesh
from tests.keys import ID, KEY
from tests.shapes import pebble

__all__ = ["marked_pebble"]


@cache
def marked_pebble(across: int = 70, **options: str) -> Embedding:
    """Return the pebble, of 2,382 vertices by default, with `ID` under `KEY`; options: as `embed` takes them."""
    return embed(Mesh(*pebble(across)), KEY, id=ID, **options)
