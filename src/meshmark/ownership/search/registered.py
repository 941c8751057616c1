"""Strategy: frames in which a reference, the certificate or the original, was registered to the suspect."""

from __future__ import annotations

from collections.abc import Iterator

from meshmark.certificate.certificate import Certificate
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import LOCK_STEPS, ORIGINAL_SPACINGS, preferred_spacings
from meshmark.ownership.search.locked import grown_readings, locked_readings
from meshmark.ownership.search.restoration import restorations, stretched
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.shapes import Hypothesis, Shapes
from meshmark.ownership.search.starting_frames import starting_frames
from meshmark.scene.surfaces import marked_surface

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
    # The original has the very invariants that its mark was made from.
    if isinstance(reference, Certificate):
        label = Label.of_hex(reference.lattice)
    else:
        label = Label.of_shape(marked_surface(reference).invariants, search.key)
    held = []
    for frame in starting_frames(search.surface, reference, search.scales):
        near = preferred_spacings(frame.area)[:ORIGINAL_SPACINGS] if known is None else known
        shapes = Shapes(search.surface, frame)
        held += [(frame, shapes, search.lattice(spacing, label)) for spacing in near]
    for restoration in restorations(search.surface, frame_known=True) if held else ():
        for frame, shapes, lattice in held:
            hypothesis = Hypothesis(restoration=restoration, lattice=lattice, turned=frame)
            yield from locked_readings(shapes, hypothesis, steps, search.trials.charge())
    restoration = stretched(search.surface.points)
    for frame, shapes, lattice in held:
        hypothesis = Hypothesis(restoration=restoration, lattice=lattice, turned=frame)
        yield from grown_readings(shapes, hypothesis, steps, DRIFT, search.trials.charge())
