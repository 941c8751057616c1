"""Strategies: the points of the surface as they stand, in its own canonical frame, or in those of a reference."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from meshmark.certificate.certificate import Certificate
from meshmark.geometry.frame import Frame, frame_alternatives
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import DECODE_LOG10
from meshmark.ownership.parameters import SURELY_SKEW as SURELY_SKEW_OF_CELLS
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.frame_sweep import peaks, sweep
from meshmark.ownership.points.parameters import MODES, MOST_POINTS, SHARES, STEPS, SURELY_SKEW
from meshmark.ownership.points.point_choice import step_number
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_reading import CHOICES, Framed, PointLock
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.starting_frames import label_of, registered_frames

__all__ = ["readings_of_points", "registered_readings_of_points"]

# Choices that are decoded, of all frames, and of those that a sweep finds.
DECODED, SWEPT = 4, 16


def readings_of_points(search: Search, *, swept: bool = True) -> Iterator[Reading]:
    """Yield the readings of those choices that lock best in any of the turns of the frame.

    swept: where moments nearly agree, the frame is turned further.
    """
    surface = search.surface
    if len(surface.points) > MOST_POINTS:
        return
    surely = SURELY_SKEW_OF_CELLS if search.wide else SURELY_SKEW
    turns = list(frame_alternatives(surface.frame, True, surely))
    labels = search.labels(surface.invariants, at_points=True)
    carried = Carried.of(surface, surface.frame)
    before = carried.before_subdivision()
    for each in (carried,) if before is None else (carried, before):
        yield from _readings(search, each, turns, labels)
        if swept:
            yield from _swept_readings(search, each, turns, labels)


def registered_readings_of_points(search: Search) -> Iterator[Reading]:
    """Yield the readings in frames that the reference gives; a certificate tells the step, too."""
    reference = search.reference
    if reference is None or len(search.surface.points) > MOST_POINTS:
        return
    label = label_of(reference, search.key)
    for frame in registered_frames(search.surface, reference, search.scales):
        carried = Carried.of(search.surface, frame)
        if isinstance(reference, Certificate):
            yield from _readings_at(search, carried, label, reference.step * reference.spacing)
        else:
            for reading in _readings(search, carried, (frame,), (label,)):
                if reading.log10_chance <= DECODE_LOG10:
                    yield reading


def _readings_at(search: Search, carried: Carried, label: Label, step: float) -> Iterator[Reading]:
    """Yield the readings of all modes in the frame of `carried`, at that of `STEPS` which is nearest to a step."""
    charge = search.trials.charge() * len(MODES) * len(SHARES)
    framed = Framed.of(search.surface, carried, carried.frame, search.point_lattice(label))
    for lock in sorted(framed.locks_at(float(STEPS[step_number(step)])), key=lambda each: each.log10_loose):
        if lock.is_readable:
            yield from lock.readings(charge, carried.frame.moments)


def _swept_readings(
    search: Search, carried: Carried, turns: Sequence[Frame], labels: Iterable[Label]
) -> Iterator[Reading]:
    """Yield readings in the best of many frames that turn the axes of nearly equal moments."""
    charge = 0.0
    swept: list[tuple[float, Frame, PointLattice]] = []
    for label in labels:
        lattice = search.point_lattice(label)
        for turned in turns:
            angles = sweep(carried, turned, lattice)
            if len(angles):
                charge += search.trials.charge() * CHOICES * len(angles)
            swept += [(score, frame, lattice) for score, frame in peaks(angles)]
    swept.sort(key=lambda entry: -entry[0])
    for _, frame, lattice in swept[:SWEPT]:
        framed = Framed.of(search.surface, carried, frame, lattice)
        lock = min(framed.locks(), key=lambda each: each.log10_loose, default=None)
        if lock is not None:
            yield from lock.readings(charge, frame.moments)


def _readings(
    search: Search, carried: Carried, turns: Sequence[Frame], labels: Iterable[Label]
) -> Iterator[Reading]:
    """Yield the readings of the best choices in any of the turns of the frame of `carried`, under any label."""
    found: list[tuple[PointLock, float]] = []
    for label in labels:
        lattice = search.point_lattice(label)
        for turned in turns:
            charge = search.trials.charge() * CHOICES
            framed = Framed.of(search.surface, carried, turned, lattice)
            found += [(lock, charge) for lock in framed.locks()]
    found.sort(key=lambda entry: entry[0].log10_loose)
    for lock, charge in found[:DECODED]:
        yield from lock.readings(charge, turns[0].moments)
