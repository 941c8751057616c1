"""Readings of a suspect that was cut by a plane: each frame that it may have had with what is gone, corrected.

A crop moves the canonical frame by far more than a lock reaches. But the cut shows, and what is gone starts at its
border: of all the frames that it may have given the model some hundred lie close to all others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from meshmark.coding.keys import Key
from meshmark.geometry.completion import completed_frames
from meshmark.geometry.frame import Frame
from meshmark.geometry.sampling import Samples, gathered, plan_samples
from meshmark.geometry.weld import Welded
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.grown_lock import MOST_FIRST, neighbourhoods
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.pose import Pose, pose_gradient
from meshmark.ownership.parameters import (
    CARRIER_READABLE,
    CROP_APART,
    CROP_CARRIERS,
    CROP_EXPECTED,
    CROP_FRAMES,
    CROP_SPACINGS,
    GATHER,
    LARGE_STEPS,
    LOCK_STEPS,
    LONGEST_SAMPLE,
    TYPICAL_STEP,
    preferred_spacings,
)
from meshmark.ownership.search.reading import Reading, read_cells
from meshmark.ownership.search.relocking import grown_locks, relocked

__all__ = ["cropped_readings"]


def cropped_readings(
    surface: Welded,
    points: FloatArray,
    key: Key,
    code_length: int,
    tickets: Iterator[int],
    wide: bool,
    spacings: Sequence[float] | None = None,
) -> Iterator[Reading]:
    """Yield the readings whose lock is credible, likeliest frames first; none of a surface without a planar cut.

    points: (p, 3) of the surface, as they are or restored; tickets: numbers of readings, which all share one bound.
    """
    frames = completed_frames(points, surface.faces, CROP_APART, CROP_FRAMES["wide" if wide else "quick"][0])
    if not frames:
        return
    suspect = _Suspect(points, surface.faces, frames[0], key)
    steps = LOCK_STEPS[:LARGE_STEPS]
    for cluster, many in enumerate(CROP_FRAMES["wide" if wide else "quick"]):
        for frame in frames[:many]:
            pose = _pose(frames[0], frame)
            for spacing in suspect.spacings(frame.area) if spacings is None else spacings:
                samples, lattice = suspect.samples(spacing), suspect.lattice(spacing)
                yield from _grown(samples, lattice, pose, steps, cluster, code_length, next(tickets))


class _Suspect:
    """What is kept of a suspect for each spacing, measured in one frame."""

    def __init__(self, points: FloatArray, faces: IntArray, home: Frame, key: Key) -> None:
        self._points, self._faces, self._key = home.to_canonical(points), faces, key
        self._samples: dict[float, Samples] = {}
        self._lattices: dict[float, Lattice] = {}
        self._carriers: dict[float, int] = {}

    def samples(self, spacing: float) -> Samples:
        """Return samples of the surface."""
        if spacing not in self._samples:
            longest = LONGEST_SAMPLE * spacing
            sampler = plan_samples(self._points, self._faces, longest)
            self._samples[spacing] = gathered(sampler(self._points), GATHER * longest)
        return self._samples[spacing]

    def lattice(self, spacing: float) -> Lattice:
        """Return the key's lattice."""
        if spacing not in self._lattices:
            self._lattices[spacing] = Lattice.keyed(self._key, spacing)
        return self._lattices[spacing]

    def spacings(self, area: float) -> list[float]:
        """Return those that an embedding into a whole of this canonical area is likeliest to have used."""
        return list(islice(filter(self._rich, preferred_spacings(area)), CROP_SPACINGS))

    def _rich(self, spacing: float) -> bool:
        if spacing not in self._carriers:
            cells = read_cells(self.samples(spacing), self.lattice(spacing), Pose.turned(np.eye(3)))
            self._carriers[spacing] = len(cells.nodes)
        return self._carriers[spacing] >= CROP_CARRIERS


def _pose(home: Frame, frame: Frame) -> Pose:
    """Return what takes canonical coordinates of one frame to those of another."""
    shift = (home.centre - frame.centre) @ frame.axes / frame.scale
    return Pose(home.axes.T @ frame.axes, home.scale / frame.scale, shift)


def _grown(
    samples: Samples,
    lattice: Lattice,
    pose: Pose,
    steps: Sequence[float],
    cluster: int,
    code_length: int,
    number: int,
) -> Iterator[Reading]:
    """Yield what locks from one cluster of cells on, the one that takes fewest corrections or one of the next."""
    cells = read_cells(samples, lattice, pose)
    if len(cells.nodes) < CARRIER_READABLE:
        return
    keys = lattice.keys(cells.nodes, code_length)
    gradient = pose_gradient(cells, lattice)
    places = cells.nodes.astype(np.float64)
    typical = 4.0 * np.pi / TYPICAL_STEP * gradient
    orders = neighbourhoods(typical * CROP_EXPECTED, places, cluster + 1)[cluster:]
    for step, correction, tried in grown_locks(
        cells, keys, gradient, CROP_EXPECTED, steps, orders, MOST_FIRST
    ):
        corrected = pose.then(correction)
        yield _anew(samples, lattice, corrected, step, code_length, number * (number + 1) * tried)


def _anew(
    samples: Samples, lattice: Lattice, pose: Pose, step: float, code_length: int, charge: float
) -> Reading:
    """Return the best reading close to where a correction puts the model, measured there."""
    for _ in range(2):  # the response of the first is from where it was before
        cells = read_cells(samples, lattice, pose)
        keys = lattice.keys(cells.nodes, code_length)
        phase, correction, tried = relocked(cells, keys, pose_gradient(cells, lattice), step)
        charge *= tried
        pose = pose.then(correction)
    return Reading.of(lattice.spacing, step, cells, keys, phase, charge)
