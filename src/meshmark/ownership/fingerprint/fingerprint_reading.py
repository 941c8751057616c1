"""Reading a fingerprint: where its pilots lock, and what its coordinates show there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.frame import frame_alternatives
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.lattice import CellKeys
from meshmark.ownership.carriers.lock import LockSearch
from meshmark.ownership.carriers.quantisation import lock_score
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.fingerprint.coherence import coherence
from meshmark.ownership.fingerprint.parameters import (
    CHOICES,
    CLEAR,
    COHERENT,
    FAR,
    FEWEST_PILOTS,
    LEAST_POINTS,
    LOCKED,
    NEAR,
    SHIFTS,
    Reach,
)
from meshmark.ownership.fingerprint.roles import are_pilots, are_witnesses, fingerprint_lattice
from meshmark.ownership.parameters import SURELY_SKEW
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.parameters import MOST_POINTS, SIDE
from meshmark.ownership.points.point_choice import Choice
from meshmark.ownership.points.point_reading import Framed
from meshmark.ownership.search.search import Search

__all__ = ["FingerprintReading", "read_fingerprint"]

# An edited copy may have a few points less than an embedding asks for.
FEWER = 0.9
# Locks that are polished, if they are less likely by chance than 10^this: one that is off may be hardly so.
POLISHED, PROMISING = 3, -4.0


@dataclass(frozen=True, eq=False, kw_only=True)
class FingerprintReading(Reading):
    """The coordinates of a fingerprint, as a reading without the witnesses.

    witness_index: (w,) which of its bits each witness carries; witness_phase: (w,) radians.
    """

    witness_index: IntArray = field(repr=False)
    witness_phase: FloatArray = field(repr=False)


def read_fingerprint(search: Search) -> FingerprintReading | None:
    """Return what the fingerprint of a surface shows, None where no pilots of this key lock."""
    surface = search.surface
    if not FEWER * LEAST_POINTS <= len(surface.points) <= MOST_POINTS:
        return None
    promising = [lock for lock in _locks(search) if lock.is_coherent or lock.log10_chance <= PROMISING]
    likely = sorted(promising, key=lambda lock: (not lock.is_coherent, lock.log10_chance))[:POLISHED]
    polished = (replace(each, hypotheses=POLISHED * each.hypotheses).polished() for each in likely)
    best = min(polished, key=lambda lock: lock.log10_bound, default=None)
    return None if best is None or best.log10_bound > LOCKED else best.reading()


def _locks(search: Search) -> Iterator[_Lock]:
    """Yield the lock of each label, turn of the frame and step."""
    surface = search.surface
    carried = Carried.of(surface, surface.frame)
    for label in search.labels(surface.invariants):
        lattice = fingerprint_lattice(search.key, label)
        for frame in frame_alternatives(surface.frame, search.wide, SURELY_SKEW):
            charge = search.trials.charge() * len(CHOICES)
            framed = Framed.of(surface, carried, frame, lattice, modes=1)
            for choice in CHOICES:
                lock = _Lock(framed=framed, choice=choice, hypotheses=charge)
                if np.count_nonzero(lock.pilots) >= FEWEST_PILOTS:
                    yield lock.shifted()


@dataclass(frozen=True, eq=False, kw_only=True)
class _Lock:
    """Pilots read in one frame."""

    framed: Framed
    choice: Choice
    hypotheses: float

    @cached_property
    def pilots(self) -> NDArray[np.bool_]:
        """(p, 3) coordinates that are pilots."""
        return self.framed.carrying(self.choice) & are_pilots(self.framed.keys.draw)

    @cached_property
    def is_coherent(self) -> bool:
        """Whether pilots agree place by place, though the frame may be turned so that they do not lock."""
        point, axis = np.nonzero(self.pilots)
        framed = self.framed
        phase = framed.phases(self.choice.step)[point, axis]
        return coherence(framed.points[point], axis, phase, framed.group[point, axis]) >= COHERENT

    @property
    def is_clear(self) -> bool:
        """Whether the pilots lie so near to where they should that no other frame fits better."""
        return float(np.cos(self.framed.phases(self.choice.step)[self.pilots]).mean()) >= CLEAR

    @cached_property
    def log10_chance(self) -> float:
        """Log10 of the chance of the pilots alone."""
        return self.framed.lock_chance(self.pilots, self.choice.step)

    @property
    def log10_bound(self) -> float:
        """The same over all that was tried so far."""
        return self.log10_chance + float(np.log10(self.hypotheses))

    def shifted(self) -> _Lock:
        """Return the lock with each axis shifted to where its pilots agree best, of `SHIFTS` places in a step.

        The least or largest coordinates of copies are shifted along each axis.
        """
        phases = np.where(self.pilots, self.framed.phases(self.choice.step), np.nan)
        wave = np.array([np.exp(1j * each[~np.isnan(each)]).sum() for each in phases.T])
        turns = np.round(-np.angle(wave) / (2.0 * np.pi) * SHIFTS) / SHIFTS
        return self._corrected(np.append(turns * self.choice.step, np.zeros(4)), float(SHIFTS) ** 3)

    def polished(self) -> _Lock:
        """Return the best lock near this one, or in a frame that is turned further where none near it is clear."""
        best = self._polished()
        if best.is_clear or not self.is_coherent:
            return best
        both = replace(self, hypotheses=2.0 * self.hypotheses)
        turned = min(both._near(FAR), key=lambda lock: lock.log10_bound)
        return min(best, turned._polished(), key=lambda lock: lock.log10_bound)

    def _polished(self) -> _Lock:
        best = self
        for reach in NEAR:
            best = min(best._near(reach), key=lambda lock: lock.log10_bound)
        return best

    def _near(self, reach: Reach) -> list[_Lock]:
        """Return this lock, and those after the best corrections within reach."""
        framed, step = self.framed, self.choice.step
        pilots = framed.first(self.pilots, reach.judges)
        search = LockSearch(
            framed.phases(step)[pilots],
            (2.0 * np.pi / step) * framed.gradient(pilots),
            np.append(reach.expected * step, [reach.turned] * 3),
            reach.deviations,
            reach.places,
            weight=np.ones(int(pilots.sum())),
        )
        found = search.polished(search.rough(reach.peaks))
        return [self, *(self._corrected(each.correction, search.tried) for each in found)]

    def _corrected(self, correction: FloatArray, tried: float) -> _Lock:
        framed = self.framed.corrected(correction)
        return _Lock(framed=framed, choice=self.choice, hypotheses=self.hypotheses * tried)

    def reading(self) -> FingerprintReading:
        """Return what the coordinates show."""
        framed, carries = self.framed, self.framed.carrying(self.choice)
        phases = framed.phases(self.choice.step)
        witness = carries & are_witnesses(framed.keys.draw)
        others = carries & ~witness
        keys = CellKeys(
            code_index=framed.keys.code_index[others],
            dither=framed.keys.dither[others],
            pilot=are_pilots(framed.keys.draw)[others],
        )
        phase = phases[others]
        score = float(lock_score(keys.factor * phase, keys.weight))
        return FingerprintReading(
            label=framed.lattice.label,
            spacing=SIDE,
            step=self.choice.step / SIDE,
            at_points=True,
            keys=keys,
            phase=phase,
            score=score,
            log10_chance=self.log10_chance,
            hypotheses=self.hypotheses,
            witness_index=framed.keys.code_index[witness],
            witness_phase=phases[witness],
        )
