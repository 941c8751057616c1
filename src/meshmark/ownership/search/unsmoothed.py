"""Readings of a coarse suspect that was smoothed, with what common tools do taken back exactly.

On a coarse mesh the mark lives in frequencies that no low-pass may touch. But smoothing by neighbours' means
multiplies each frequency x of the mesh by (1 - s x)^n, s its strength and n its passes, and that has an inverse:
nothing is missing then but what rounding lost. Half a pass too many spoils it, so each number of passes that people
are likely to choose is tried (docs/decisions/0013).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import Final

import numpy as np

from meshmark.geometry.areas import face_areas
from meshmark.geometry.frame import Frame, frame_alternatives
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.scale_space import spectral_filters
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.pose import Pose
from meshmark.ownership.carriers.quantisation import lock_score, log10_lock_chance
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import (
    CARRIER_PLENTY,
    CARRIER_READABLE,
    CREDIBLE_LOG10,
    LABELS,
    LOCK_STEPS,
    LOCK_TURNS,
    LONGEST_SAMPLE,
    SPACING_ORDER,
    SPACING_TRIES,
    SURELY_SKEW,
)
from meshmark.ownership.search.measurement import CellReading, Measurement, read_cells
from meshmark.ownership.search.restoration import Shape
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.shapes import Shapes

__all__ = ["unsmoothed_readings"]

# What may have been done: shares of the way to the neighbours' mean, one after another, and how many times that.
SMOOTHINGS: Final[dict[tuple[float, ...], tuple[int, ...]]] = {
    (0.1,): (1, 2, 3, 5, 10, 15, 20, 30, 50),
    (0.5,): (1, 2, 3, 4, 5, 6),
    (0.5, -0.53): (1, 2, 3, 5, 10),  # Taubin's, doi:10.1145/218380.218473
}
# A frequency of which less is left than this is held back: a tenth of what is left of the frequency 1.95 (of at
# most 2), but between these shares; nothing is where more is left of all frequencies.
FAINTEST, FAINT, HIGH = 1e-5, 1e-2, 1.95
TERMS: Final = 300
# Where more is undone than was done the surface gets rough. One with this number of times the area was never the
# model.
ROUGHEST: Final = 6.0
# Shapes are first read with samples up to this long, in spacings. A lock that is credible by the usual ones is less
# likely by chance there than 10^SCREENED (decision 0044); without a mark one in thirty is.
COARSE_SAMPLE, SCREENED = 0.5, -1.5
# Most shapes, spacings and steps that are tried, and most turns of each: two, or with axes exchanged all.
TRIED: Final = sum(map(len, SMOOTHINGS.values())) * len(SPACING_ORDER) * len(LOCK_STEPS)
TURNS: Final = {False: LOCK_TURNS, True: 24}


@dataclass(frozen=True, eq=False, kw_only=True)
class _Guess:
    """A shape that the suspect may have had, in a frame, and how unlikely its lock is at this spacing and step."""

    log10_chance: float
    points: FloatArray
    frame: Frame
    lattice: Lattice
    step: float

    def read(self, search: Search, hypotheses: float) -> Reading:
        """Measure the shape anew, with all samples instead of gathered ones."""
        lattice = self.lattice
        canonical = self.frame.to_canonical(self.points)
        sampler = plan_samples(canonical, search.surface.faces, LONGEST_SAMPLE * lattice.spacing)
        measured = Measurement.of(lattice, read_cells(sampler(canonical), lattice, Pose.turned(np.eye(3))))
        return CellReading.of(measured, self.step, measured.phase(self.step), hypotheses)


def unsmoothed_readings(search: Search) -> Iterator[Reading]:
    """Yield each reading whose lock is credible, of all that may have been done; none of a fine mesh."""
    if not search.is_coarse:
        return
    coarse, usual = Shapes(search.surface, longest=COARSE_SAMPLE), Shapes(search.surface)
    labels = LABELS[search.effort] if search.wide else 1
    tried = TRIED * TURNS[search.wide] * labels
    for points in _before(search.surface):
        for guess in _guesses(search, coarse, usual, Shape(points)):
            if guess.log10_chance + np.log10(tried) < CREDIBLE_LOG10:
                yield guess.read(search, search.trials.charge() * tried)


def _before(surface: Surface) -> Iterator[FloatArray]:
    """Yield the shapes (p, 3) that the suspect may have had before."""
    centre = surface.points.mean(axis=0)
    filters = [_inverse(shares, n) for shares, passes in SMOOTHINGS.items() for n in passes]
    area = face_areas(surface.points, surface.faces).sum()
    for part in spectral_filters(surface.walk, surface.points - centre, filters, TERMS):
        if face_areas(part, surface.faces).sum() < ROUGHEST * area:
            yield centre + part


def _inverse(shares: Sequence[float], passes: int) -> Callable[[FloatArray], FloatArray]:
    """Return the inverse of `passes` passes; where they leave next to nothing it is held back."""

    def left(x: FloatArray) -> FloatArray:
        return np.asarray(np.prod([(1.0 - share * x) ** passes for share in shares], axis=0))

    high, highest = left(np.array([HIGH, 2.0]))
    least = 0.0 if highest > FAINT else float(np.clip(0.1 * high, FAINTEST, FAINT))
    return lambda x: left(x) / (left(x) ** 2 + least**2)


def _guesses(search: Search, coarse: Shapes, usual: Shapes, shape: Shape) -> Iterator[_Guess]:
    """Yield the best step of a shape for each spacing and turn that an embedding may have used.

    coarse: reads all of them, usual: those that may lock.
    """
    frame = coarse.frame(shape)
    turns = list(frame_alternatives(frame, search.wide, SURELY_SKEW))
    # Many shapes are tried, and of the right one the first label is the right one nearly always.
    labels = search.labels(coarse.invariants(shape))[: None if search.wide else 1]
    rich = 0
    for spacing in search.spacings_for(frame.area):
        lattices = [search.lattice(spacing, label) for label in labels]
        count = 0
        for lattice, turned in product(lattices, islice(turns, TURNS[search.wide])):
            carriers = coarse.carriers(shape, lattice, turned)
            count = len(carriers.nodes)
            if count < CARRIER_READABLE:
                break
            if _best_step(lattice, carriers)[0] < SCREENED:
                chance, step = _best_step(lattice, usual.carriers(shape, lattice, turned))
                yield _Guess(
                    log10_chance=chance, points=shape.points, frame=turned, lattice=lattice, step=step
                )
        rich += count >= CARRIER_PLENTY
        if rich == (SPACING_TRIES if search.wide else 1):
            return


def _best_step(lattice: Lattice, carriers: Cells) -> tuple[float, float]:
    """Return log10 of the chance of the lock of the step that locks best, and the step."""
    measured = Measurement.of(lattice, carriers)
    scores = lock_score(measured.psi(np.array(LOCK_STEPS)[:, None]), measured.keys.weight)
    best = int(scores.argmax())
    return log10_lock_chance(float(scores[best]), len(measured)), LOCK_STEPS[best]
