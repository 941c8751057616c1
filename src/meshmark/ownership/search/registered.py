"""Strategy: frames in which a reference, the certificate or the original, was registered to the suspect."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice

from meshmark.certificate.certificate import Certificate
from meshmark.geometry.frame import Frame
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import LOCK_STEPS, ORIGINAL_SPACINGS, preferred_spacings
from meshmark.ownership.search.locked import grown_readings, locked_readings
from meshmark.ownership.search.restoration import Restoration, restorations, stretched
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.shapes import Hypothesis, Shapes
from meshmark.ownership.search.starting_frames import corner_frames, label_of, starting_frames

__all__ = ["registered_readings"]

# A registration has to make do with a stretched suspect: it is off by more than a frame that has followed.
DRIFT = 1.6


def registered_readings(search: Search) -> Iterator[Reading]:
    """Yield corrected readings in frames that the reference gives."""
    reference = search.reference
    if reference is None:
        return
    known = (reference.spacing,) if isinstance(reference, Certificate) else None
    steps = (reference.step,) if isinstance(reference, Certificate) else LOCK_STEPS
    label = label_of(reference, search.key)

    def placed(frames: Iterable[Frame]) -> list[tuple[Frame, Shapes, Lattice]]:
        return [
            (frame, shapes, search.lattice(spacing, label))
            for frame in frames
            for shapes in [Shapes(search.surface, frame)]  # one for all spacings
            for spacing in (preferred_spacings(frame.area)[:ORIGINAL_SPACINGS] if known is None else known)
        ]

    def read(held: list[tuple[Frame, Shapes, Lattice]], restored: Iterable[Restoration]) -> Iterator[Reading]:
        for restoration in restored:
            for frame, shapes, lattice in held:
                hypothesis = Hypothesis(restoration=restoration, lattice=lattice, turned=frame)
                yield from locked_readings(shapes, hypothesis, steps, search.trials.charge())

    # A part of the model, unchanged: registered exactly, and soon.
    if exact := placed(corner_frames(search.surface, reference)):
        yield from read(exact, islice(restorations(search.surface, frame_known=True), 1))
    held = placed(starting_frames(search.surface, reference, search.scales))
    if not held:
        return
    yield from read(held, restorations(search.surface, frame_known=True))
    restoration = stretched(search.surface.points)
    for frame, shapes, lattice in held:
        hypothesis = Hypothesis(restoration=restoration, lattice=lattice, turned=frame)
        yield from grown_readings(shapes, hypothesis, steps, DRIFT, search.trials.charge())
