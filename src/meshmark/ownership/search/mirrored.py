"""Strategy: the mirror image of the surface, as it stands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from meshmark.ownership.search.as_it_stands import readings_as_it_stands
from meshmark.ownership.search.measurement import Reading
from meshmark.ownership.search.search import Search

__all__ = ["mirrored_readings"]


def mirrored_readings(search: Search) -> Iterator[Reading]:
    """Yield the readings of the mirror image."""
    surface = search.surface
    image = replace(surface, points=surface.points * [-1.0, 1.0, 1.0], faces=surface.faces[:, ::-1])
    for reading in readings_as_it_stands(replace(search, surface=image)):
        yield replace(reading, mirrored=True)
