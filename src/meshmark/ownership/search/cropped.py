"""Readings of a suspect that was cut by a plane: each frame that it may have had with what is gone, corrected.

A crop moves the canonical frame by far more than a lock reaches, and what a label is made of as well. But the cut
shows, and what is gone starts at its border: of all the frames that it may have given the model some hundred lie
close to all others, those first that stand for most, and each comes with a cap that the label is made of, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice

import numpy as np

from meshmark.geometry.completion import Completed, completed_frames
from meshmark.geometry.frame import Frame
from meshmark.geometry.invariants import LONGEST, sampled_invariants
from meshmark.geometry.sampling import SamplerPlans, Samples, gathered
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.grown_lock import MOST_FIRST, neighbourhood
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.pose import Pose, pose_gradient
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import (
    CARRIER_MOST,
    CARRIER_READABLE,
    CROP_APART,
    CROP_CARRIERS,
    CROP_EXPECTED,
    CROP_FRAMES,
    CROP_LABELS,
    CROP_SPACINGS,
    GATHER,
    LOCK_STEPS,
    LONGEST_SAMPLE,
    TYPICAL_STEP,
    preferred_spacings,
)
from meshmark.ownership.search.locked import grown_locks, relocked
from meshmark.ownership.search.measurement import CellReading, Measurement, read_cells
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.shapes import Response

__all__ = ["cropped_readings"]


def cropped_readings(search: Search) -> Iterator[Reading]:
    """Yield the readings whose lock is credible, likeliest frames first; none of a surface without a planar cut."""
    surface = search.surface
    wholes = completed_frames(surface.points, surface.faces, CROP_APART, CROP_FRAMES[search.effort])
    if not wholes:
        return
    suspect = _Suspect(search, wholes[0].frame)
    for whole in wholes:
        pose = _pose(wholes[0].frame, whole.frame)
        known = search.spacings
        for label in suspect.labels(whole, pose):
            for spacing in suspect.spacings(whole.frame.area) if known is None else known:
                lattice = search.lattice(spacing, label)
                place = _Place(samples=suspect.samples(spacing), lattice=lattice, pose=pose)
                yield from _grown(place, search.trials.charge())


class _Suspect:
    """What is kept of a suspect for each spacing, measured in one frame."""

    def __init__(self, search: Search, home: Frame) -> None:
        self._points, self._search = home.to_canonical(search.surface.points), search
        surface = search.surface
        self._home = home
        self._plans = SamplerPlans(surface.faces, surface.face_lengths / home.scale)
        self._samples: dict[float, Samples] = {}
        self._carriers: dict[float, int] = {}

    def samples(self, spacing: float) -> Samples:
        """Return samples of the surface."""
        if spacing not in self._samples:
            longest = LONGEST_SAMPLE * spacing
            sampler = self._plans.plan(self._points, longest)
            self._samples[spacing] = gathered(sampler(self._points), GATHER * longest)
        return self._samples[spacing]

    def labels(self, whole: Completed, pose: Pose) -> tuple[Label, ...]:
        """Return the likeliest labels of the surface together with a cap, whose frame is at a pose from this."""
        frame = whole.frame
        positions = np.concatenate([pose(self._described.positions), frame.to_canonical(whole.places)])
        share = whole.area / len(whole.places) / self._home.scale**2
        areas = np.concatenate([self._described.areas, np.full(len(whole.places), share)])
        invariants = sampled_invariants(positions, areas, frame)
        return self._search.labels(invariants, undone=True)[: CROP_LABELS[self._search.effort]]

    @cached_property
    def _described(self) -> Samples:
        """Samples that `shape_invariants` would take, or coarser ones."""
        sampler = self._plans.plan(self._points, LONGEST)
        return gathered(sampler(self._points), GATHER * LONGEST)

    def spacings(self, area: float) -> list[float]:
        """Return those that an embedding into a whole of this canonical area is likeliest to have used."""
        return list(islice(filter(self._rich, preferred_spacings(area)), CROP_SPACINGS))

    def _rich(self, spacing: float) -> bool:
        if spacing not in self._carriers:
            lattice = self._search.lattice(spacing, self._search.labels(self._search.surface.invariants)[0])
            cells = read_cells(self.samples(spacing), lattice, Pose.turned(np.eye(3)))
            self._carriers[spacing] = len(cells.nodes)
        return self._carriers[spacing] >= CROP_CARRIERS


def _pose(home: Frame, frame: Frame) -> Pose:
    """Return what takes canonical coordinates of one frame to those of another."""
    shift = (home.centre - frame.centre) @ frame.axes / frame.scale
    return Pose(turn=home.axes.T @ frame.axes, scale=home.scale / frame.scale, shift=shift)


@dataclass(frozen=True, kw_only=True)
class _Place:
    """Canonical samples of the suspect, and the pose that puts them on a lattice."""

    samples: Samples
    lattice: Lattice
    pose: Pose

    def measured(self) -> Response:
        """Measure the cells there."""
        cells = read_cells(self.samples, self.lattice, self.pose)
        return Response(Measurement.of(self.lattice, cells), pose_gradient(cells, self.lattice))

    def then(self, correction: FloatArray) -> _Place:
        """Return the place after a correction (7,)."""
        return replace(self, pose=self.pose.then(correction))


def _grown(place: _Place, charge: float) -> Iterator[Reading]:
    """Yield what locks from a first cluster of cells on."""
    response = place.measured()
    if not CARRIER_READABLE <= len(response) <= CARRIER_MOST:
        return
    places = response.measured.cells.nodes.astype(np.float64)
    typical = response.measured.turn(response.gradient, TYPICAL_STEP)
    order = neighbourhood(typical * CROP_EXPECTED, places, response.measured.keys.weight)
    for step, correction, tried in grown_locks(response, CROP_EXPECTED, LOCK_STEPS, order, MOST_FIRST):
        yield _anew(place.then(correction), step, charge * tried)


def _anew(place: _Place, step: float, charge: float) -> Reading:
    """Return the best reading close to where a correction puts the model, measured there."""
    for _ in range(2):  # the response of the first is from where it was before
        response = place.measured()
        phase, correction, tried = relocked(response.measured, response.gradient, step)
        charge *= tried
        place = place.then(correction)
    return CellReading.of(response.measured, step, phase, charge)
