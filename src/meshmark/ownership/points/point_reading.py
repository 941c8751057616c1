"""Points read under one hypothesis of the frame: which step, mode and share lock best, and what they say."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.frame import Frame
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.lattice import CellKeys
from meshmark.ownership.carriers.lock import LockSearch
from meshmark.ownership.carriers.pose import POSE_SIZE, Pose, moved_along
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.lock_chance import log10_lock_chance, log10_loose_chance
from meshmark.ownership.points.parameters import FEW_POINTS, MODES, READABLE, SHARES, SIDE, STEPS
from meshmark.ownership.points.point_choice import Choice, cuts_of, step_number
from meshmark.ownership.points.point_lattice import PointKeys, PointLattice
from meshmark.ownership.points.screened_shares import ScreenedShares
from meshmark.ownership.quick_waves import quick_wave

__all__ = ["CHOICES", "Framed", "PointLock"]

CHOICES = len(STEPS) * len(MODES) * len(SHARES)
"""Number of choices of a step, a mode and a share."""
# More coordinates are not read where only the best choices are looked for.
SCREENED = 8000
# Standard deviations of what is left to correct of a frame: in steps, and of a turn, besides, in radians, over the
# gap between the second moments along the two axes that it turns, and at most; how many of them are looked at.
EXPECTED, TURNED, TURNED_MOST, REACH = 0.25, 2e-5, 0.008, 2.5
# Corrections that are tried, and coordinates that they are judged by.
CORRECTIONS, JUDGES = 2, 1000
# Corrections that differ by less, in standard deviations of each part, are one.
SAME = 0.02


@dataclass(frozen=True, eq=False, kw_only=True)
class PointLock:
    """A choice, where it locks in a frame, and its `log10_loose_chance`, by which choices are compared.

    The closer bound prefers small shares of a mark that happen to contain only points that could be set.
    """

    log10_loose: float
    framed: Framed
    choice: Choice

    @property
    def is_readable(self) -> bool:
        """Whether enough coordinates carry."""
        return int(np.count_nonzero(self.framed.carrying(self.choice))) >= self.framed.readable

    def readings(self, hypotheses: float, moments: FloatArray) -> Iterator[Reading]:
        """Yield the reading of this choice, then those with the frame corrected.

        hypotheses: that it is the best of. moments: (3,) of the frame, shares of their sum.
        """
        framed = self.framed
        choice = framed.best_share(self.choice).choice
        yield framed.reading(choice, hypotheses)
        carries = framed.carrying(choice)
        if np.count_nonzero(carries) < READABLE[-1]:
            return
        turned = [TURNED / max(abs(moments[i - 1] - moments[i - 2]), TURNED / TURNED_MOST) for i in range(3)]
        expected = EXPECTED * choice.step + np.array([0.0] * 4 + turned)
        judges = framed.first(carries, JUDGES)
        psi = 2.0 * framed.phases(choice.step)[judges]
        gradient = (4.0 * np.pi / choice.step) * framed.gradient(judges)
        search = LockSearch(psi, gradient, expected, REACH, weight=np.ones(len(psi)))
        # Where shapes repeat, other corrections lock as well, half a step away: the true one is close to zero.
        known: list[FloatArray] = [np.zeros(POSE_SIZE)]
        for lock in search.polished([search.at_rest(), *search.rough(CORRECTIONS)]):
            if min(np.abs((lock.correction - each) / expected).max() for each in known) < SAME:
                continue
            known.append(lock.correction)
            corrected = framed.corrected(lock.correction)
            yield corrected.reading(choice, hypotheses * search.tried)


@dataclass(frozen=True, eq=False, kw_only=True)
class Framed:
    """The points of a suspect in a frame, with what the key says of them there.

    points: (p, 3) in the frame; coordinates: (p, 3) for each of `MODES`, which carry; room: (steps, p), where there
    is room for each of `STEPS`; group: (p, 3) coordinates with one number share what the key says. fitted: these
    points corrected the frame.
    """

    points: FloatArray
    coordinates: tuple[NDArray[np.bool_], ...]
    room: NDArray[np.bool_]
    lattice: PointLattice
    keys: PointKeys
    group: IntArray
    fitted: bool = False

    @classmethod
    def of(
        cls,
        surface: Surface,
        carried: Carried,
        frame: Frame,
        lattice: PointLattice,
        *,
        modes: int = len(MODES),
    ) -> Framed:
        """Read a surface in a turn of the frame that `carried` was found in.

        modes: how many of the first of `MODES` are read.
        """
        points = frame.to_canonical(surface.points)
        keys = lattice.keys(lattice.cubes(points))
        coordinates = carried.turned(carried.frame.axes.T @ frame.axes, keys.first, modes)
        return cls(
            points=points,
            coordinates=coordinates,
            room=carried.room,
            lattice=lattice,
            keys=keys,
            group=_group(keys),
        )

    def corrected(self, correction: FloatArray) -> Framed:
        """Return the points in a frame that is off by a small pose (7,): shift, logarithm of scale, turn."""
        pose = Pose.turned(np.eye(3)).then(correction)
        points = pose(self.points)
        keys = self.lattice.keys(self.lattice.cubes(points))
        return replace(self, points=points, keys=keys, group=_group(keys), fitted=True)

    def phases(self, step: float) -> FloatArray:
        """Return the phases (p, 3), radians, at a step in canonical units."""
        return _phases(self.points, step, self.keys.dither)

    def carrying(self, choice: Choice) -> NDArray[np.bool_]:
        """Return (p, 3): the coordinates that carry under a choice."""
        room = self.room[step_number(choice.step)]
        return choice.carrying(self.coordinates[choice.mode], room, self.keys.draw)

    def first(self, carries: NDArray[np.bool_], most: int) -> NDArray[np.bool_]:
        """Return (p, 3): of the coordinates that carry those with the lowest draws, at most this number."""
        draw = self.keys.draw[carries]
        return carries if len(draw) <= most else carries & (self.keys.draw < np.partition(draw, most)[most])

    def gradient(self, carries: NDArray[np.bool_]) -> FloatArray:
        """Return (n, 7): the change of the carrying coordinates for a small pose."""
        point, axis = np.nonzero(carries)
        place, unit = self.points[point], np.eye(3)[axis]
        return moved_along(place, unit)

    def locks(self) -> Iterator[PointLock]:
        """Yield the best choice for each step and mode, of large models judged by some of the coordinates."""
        few = self.first(self.coordinates[-1], SCREENED)
        order = np.argsort(self.keys.draw[few], kind="stable")
        draw, place, dither = (each[few][order] for each in (self.keys.draw, self.points, self.keys.dither))
        group = self.group[few][order]
        last = np.zeros(0, bool)
        modes: list[ScreenedShares] = []
        for step, room in zip(STEPS, self.room, strict=True):
            if not room.any():
                continue
            if not np.array_equal(room, last):  # small steps have the same room
                last, modes = room, []
                for mode, coordinates in enumerate(self.coordinates):
                    carries = (coordinates & room[:, None])[few][order]
                    modes.append(ScreenedShares.of(carries, draw, group, cuts_of(mode), self.readable))
            cosine, sine = quick_wave(2.0 * (place / step - dither))
            for mode, shares in enumerate(modes):
                chances = shares.log10_chances(cosine, sine)
                if chances:
                    best = min(chances)
                    choice = Choice(step=float(step), mode=mode, share=SHARES[chances.index(best)])
                    yield PointLock(log10_loose=best, framed=self, choice=choice)

    def best_at(self, step: float) -> Choice:
        """Return the choice of a step, one of `STEPS`, that locks best, first of those with enough coordinates."""
        return min(self.locks_at(step), key=lambda lock: (not lock.is_readable, lock.log10_loose)).choice

    def locks_at(self, step: float) -> list[PointLock]:
        """Return the lock of the best share of each mode for a step, one of `STEPS`."""
        return [self.best_share(Choice(step=step, mode=mode, share=1.0)) for mode in range(len(MODES))]

    def best_share(self, choice: Choice) -> PointLock:
        """Return the lock of the best share, by all coordinates, of the first one and those that have enough."""
        carries = self.carrying(replace(choice, share=SHARES[0]))
        draw, group = self.keys.draw[carries], self.group[carries]
        wave = np.exp(2j * self.phases(choice.step)[carries])
        locks: list[PointLock] = []
        for share in SHARES:
            shared = replace(choice, share=share)
            kept = draw < shared.cut
            if locks and np.count_nonzero(kept) < self.readable:
                break  # nor have smaller ones
            score, sizes = _summed(wave[kept], group[kept])
            chance = log10_loose_chance(score, float(sizes @ sizes))
            locks.append(PointLock(log10_loose=chance, framed=self, choice=shared))
        return min(locks, key=lambda lock: lock.log10_loose)

    def reading(self, choice: Choice, hypotheses: float) -> Reading:
        """Return what the points say under a choice."""
        carries = self.carrying(choice)
        phase = self.phases(choice.step)[carries]
        score, sizes = _summed(np.exp(2j * phase), self.group[carries])
        keys = CellKeys(
            code_index=self.keys.code_index[carries],
            dither=self.keys.dither[carries],
            pilot=np.zeros(len(phase), bool),
        )
        return Reading(
            label=self.lattice.label,
            spacing=SIDE,
            step=choice.step / SIDE,
            at_points=True,
            keys=keys,
            phase=phase,
            score=score,
            log10_chance=log10_lock_chance(score, sizes, fitted=self.fitted),
            hypotheses=hypotheses,
        )

    def lock_chance(self, carries: NDArray[np.bool_], step: float) -> float:
        """Return log10 of the chance of the phases of coordinates (p, 3) that say 0 on every copy."""
        score, sizes = _summed(np.exp(1j * self.phases(step)[carries]), self.group[carries])
        return log10_lock_chance(score, sizes, fitted=self.fitted)

    @property
    def readable(self) -> int:
        """The number of coordinates from which on they are read."""
        return READABLE[0] if len(self.points) < FEW_POINTS else READABLE[1]


def _phases(places: FloatArray, step: float, dither: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.pi * (places / step - dither))


def _summed(wave: NDArray[np.complex128], group: IntArray) -> tuple[float, FloatArray]:
    """Return the real part of the sum of all waves, and the size of the sum of each group."""
    real, imaginary = (np.bincount(group, part).astype(np.float64) for part in (wave.real, wave.imag))
    return float(real.sum()), np.sqrt(real**2 + imaginary**2)


def _group(keys: PointKeys) -> IntArray:
    """Return (p, 3): coordinates with one number share what the key says."""
    return np.asarray(3 * keys.cube[:, None] + np.arange(3))
