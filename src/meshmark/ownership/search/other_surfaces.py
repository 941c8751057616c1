"""Strategies: other surfaces as they stand: those of a scene with copies counted once, and the mirror image."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.search.as_it_stands import readings_as_it_stands
from meshmark.ownership.search.at_points import readings_of_points
from meshmark.ownership.search.search import Search

__all__ = ["mirrored_readings", "readings_of_copies"]


def readings_of_copies(search: Search) -> Iterator[Reading]:
    """Yield the readings of each further surface that may carry the mark."""
    for surface in search.copies:
        single = replace(search, surface=surface)
        if single.has_cells:
            yield from readings_as_it_stands(single)
        yield from readings_of_points(single, swept=False)


def mirrored_readings(search: Search) -> Iterator[Reading]:
    """Yield the readings of the mirror image."""
    mirrored = replace(search, surface=search.surface.mirrored())
    in_cells = readings_as_it_stands(mirrored) if search.has_cells else ()
    for reading in chain(in_cells, readings_of_points(mirrored)):
        yield replace(reading, mirrored=True)
