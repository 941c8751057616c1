"""Strategies: the points of the surface as they stand, in its own canonical frame, or in those of a reference."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from meshmark.certificate.certificate import Certificate
from meshmark.geometry.frame import Frame, frame_alternatives
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import SURELY_SKEW
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_reading import CHOICES, Framed, PointLock
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.starting_frames import starting_frames
from meshmark.scene.surfaces import marked_surface

__all__ = ["readings_of_points", "registered_readings_of_points"]

# Choices that are decoded, of all frames.
DECODED = 4


def readings_of_points(search: Search) -> Iterator[Reading]:
    """Yield the readings of those choices that lock best in any of the turns of the frame."""
    surface = search.surface
    turns = list(frame_alternatives(surface.frame, True, SURELY_SKEW))
    labels = search.labels(surface.invariants)
    carried = Carried(surface, surface.frame)
    yield from _readings(search, carried, turns, labels)
    if (before := carried.before_subdivision()) is not None:
        yield from _readings(search, before, turns, labels)


def registered_readings_of_points(search: Search) -> Iterator[Reading]:
    """Yield the readings in frames that the reference gives."""
    reference = search.reference
    if reference is None:
        return
    if isinstance(reference, Certificate):
        label = Label.of_hex(reference.lattice)
    else:
        label = Label.of_shape(marked_surface(reference).invariants, search.key)
    for frame in starting_frames(search.surface, reference):
        carried = Carried(search.surface, frame)
        yield from _readings(search, carried, (frame,), (label,))


def _readings(
    search: Search, carried: Carried, turns: Sequence[Frame], labels: Iterable[Label]
) -> Iterator[Reading]:
    """Yield the readings of the best choices in any of the turns of the frame of `carried`, under any label."""
    found: list[tuple[PointLock, float]] = []
    for label in labels:
        lattice = PointLattice.keyed(search.key, label)
        for turned in turns:
            charge = search.trials.charge() * CHOICES
            framed = Framed.of(search.surface, carried, turned, lattice)
            found += [(lock, charge) for lock in framed.locks()]
    found.sort(key=lambda entry: entry[0].log10_chance)
    for lock, charge in found[:DECODED]:
        yield from lock.readings(charge, turns[0].moments)
