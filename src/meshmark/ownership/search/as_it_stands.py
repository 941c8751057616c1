"""Strategy: the surface as it stands, in its own canonical frame."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from meshmark.geometry.frame import frame_alternatives
from meshmark.geometry.sampling import SamplerPlans
from meshmark.ownership.carriers.pose import Pose
from meshmark.ownership.carriers.quantisation import lock_score
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import (
    CARRIER_MOST,
    CARRIER_PLENTY,
    CARRIER_READABLE,
    LONGEST_SAMPLE,
    SPACING_TRIES,
    STEPS,
    SURELY_SKEW,
)
from meshmark.ownership.search.measurement import CellReading, Measurement, read_cells
from meshmark.ownership.search.search import Search

__all__ = ["readings_as_it_stands"]


def readings_as_it_stands(search: Search) -> Iterator[Reading]:
    """Yield a reading for each spacing and frame alternative with enough cells, likeliest first."""
    surface = search.surface
    frame = surface.frame
    canonical = frame.to_canonical(surface.points)
    plans = SamplerPlans(surface.faces, surface.face_lengths / frame.scale)
    sampler, samples = None, None
    rich = 0
    labels = search.labels(surface.invariants)
    for spacing in search.spacings_for(frame.area):
        lattices = [search.lattice(spacing, label) for label in labels]
        plan = plans.plan(canonical, LONGEST_SAMPLE * spacing)
        if samples is None or plan is not sampler:
            sampler, samples = plan, plan(canonical)
        fewest = 0
        others = frame_alternatives(frame, search.wide, np.inf if search.wide else SURELY_SKEW)
        for lattice, other in product(lattices, others):
            cells = read_cells(samples, lattice, Pose.turned(frame.axes.T @ other.axes))
            fewest = min(fewest or len(cells.nodes), len(cells.nodes))
            if not CARRIER_READABLE <= fewest <= CARRIER_MOST:
                break  # about as many whichever way the lattice lies
            charge = search.trials.charge()
            yield _at_best_step(Measurement.of(lattice, cells), charge)
        rich += fewest >= CARRIER_PLENTY
        if rich == SPACING_TRIES and not search.wide:
            return


def _at_best_step(measured: Measurement, charge: float) -> Reading:
    phases = measured.phase(STEPS[:, None])
    best = int(np.argmax(lock_score(measured.keys.factor * phases, measured.keys.weight)))
    return CellReading.of(measured, float(STEPS[best]), phases[best], len(STEPS) * charge)
