"""Strategy: the suspect as it was before a small non-uniform scaling.

A stretch moves cells by many steps; grown from cells with single phases, the lock finds it all the same.
"""

from __future__ import annotations

from collections.abc import Iterator

from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import LOCK_STEPS
from meshmark.ownership.search.locked import grown_readings
from meshmark.ownership.search.restoration import stretched
from meshmark.ownership.search.restored import hypotheses
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.shapes import Shapes

__all__ = ["stretched_readings"]

# The frames of stretched shapes have followed: this share of the usual drift is left.
DRIFT = 0.6


def stretched_readings(search: Search) -> Iterator[Reading]:
    """Yield readings of the suspect as it was before a small stretch, whose lock is credible."""
    shapes = Shapes(search.surface)
    for hypothesis in hypotheses(search, shapes, stretched(search.surface.points)):
        yield from grown_readings(shapes, hypothesis, LOCK_STEPS, DRIFT, search.trials.charge())
