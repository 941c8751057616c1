"""Strategy: the surfaces that are left of a scene where copies of one mesh are counted once, as they stand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.search.as_it_stands import readings_as_it_stands
from meshmark.ownership.search.at_points import readings_of_points
from meshmark.ownership.search.search import Search

__all__ = ["readings_of_copies"]


def readings_of_copies(search: Search) -> Iterator[Reading]:
    """Yield the readings of each further surface that may carry the mark."""
    for surface in search.copies:
        single = replace(search, surface=surface)
        if single.has_cells:
            yield from readings_as_it_stands(single)
        yield from readings_of_points(single, swept=False)
