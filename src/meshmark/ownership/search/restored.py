"""Strategy: each restoration of the suspect's shape in its own frame, corrected by the lattice lock."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, product

from meshmark.geometry.frame import frame_alternatives
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import (
    CARRIER_ENOUGH,
    LOCK_STEPS,
    LOCK_TURNS,
    RESTORED_LOG10,
    SURELY_SKEW,
    preferred_spacings,
)
from meshmark.ownership.search.locked import locked_readings
from meshmark.ownership.search.restoration import Restoration, restorations
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.shapes import Hypothesis, Shapes

__all__ = ["hypotheses", "restored_readings"]


def restored_readings(search: Search) -> Iterator[Reading]:
    """Yield the best few corrected readings of each restoration, spacing and turn, likeliest first.

    Unless the search is wide, only those whose lock stands out, and of coarse meshes the shape as it stands alone.
    """
    shapes = Shapes(search.surface)
    most = None if search.wide or search.bears_filters else 1
    for restoration in islice(restorations(search.surface), most):
        for hypothesis in hypotheses(search, shapes, restoration):
            for reading in locked_readings(shapes, hypothesis, LOCK_STEPS, search.trials.charge()):
                if search.wide or reading.log10_chance <= RESTORED_LOG10:
                    yield reading


def hypotheses(search: Search, shapes: Shapes, restoration: Restoration) -> Iterator[Hypothesis]:
    """Yield the spacings and turns of a restoration in its own frame."""
    frame = shapes.frame(restoration.shapes[0])
    labels = search.labels(shapes.middle_invariants(restoration), undone=len(restoration.shapes) == 2)
    known = search.spacings
    for spacing in _rich_spacings(search, shapes, restoration, labels[0]) if known is None else known:
        turns = frame_alternatives(frame, search.wide, SURELY_SKEW)
        for turned, label in product(turns if search.wide else islice(turns, LOCK_TURNS), labels):
            yield Hypothesis(restoration=restoration, lattice=search.lattice(spacing, label), turned=turned)


def _rich_spacings(search: Search, shapes: Shapes, restoration: Restoration, label: Label) -> Iterator[float]:
    """Yield the first spacing with carriers enough, or all such; none where the shape has fallen apart."""
    shape = restoration.shapes[0]
    frame = shapes.frame(shape)
    for spacing in preferred_spacings(frame.area):
        carriers = shapes.carriers(shape, search.lattice(spacing, label), frame)
        if len(carriers.nodes) < CARRIER_ENOUGH:
            continue
        yield spacing
        if not search.wide:
            return
