"""The lock of an id where its certificate says that it lies, without any search but the turns of the frame."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from meshmark.certificate.certificate import Certificate
from meshmark.coding.keys import Key
from meshmark.geometry.frame import Frame, canonical_frame, frame_alternatives
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.pose import Pose
from meshmark.ownership.carriers.quantisation import bit_phase
from meshmark.ownership.parameters import LONGEST_SAMPLE, SURELY_SKEW
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.parameters import SIDE, STEPS
from meshmark.ownership.points.point_choice import step_number
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_reading import Framed
from meshmark.ownership.search.measurement import read_cells

__all__ = ["WrittenLock", "reader_of"]


@dataclass(frozen=True, eq=False, kw_only=True)
class WrittenLock:
    """How carriers lock where a certificate says that they lie.

    frame: that they were read in; nodes: (n, 3) which they are; phase: (n,) radians.
    """

    frame: Frame
    nodes: IntArray
    phase: FloatArray

    @property
    def score(self) -> float:
        """Return the sum of the cosines of the doubled phases."""
        return float(np.cos(2.0 * self.phase).sum())

    def agreement(self, other: WrittenLock) -> float:
        """Return the mean cos of twice the angle between the phases of the two; a cell that is gone counts 0."""
        row = find_nodes(other.nodes, self.nodes)
        turned = self.phase[row >= 0] - other.phase[row[row >= 0]]
        return float(np.cos(2.0 * turned).sum()) / len(row) if len(row) else 1.0


class WrittenReader(ABC):
    """Reads the carriers that a certificate names."""

    def __init__(self, surface: Surface) -> None:
        self._surface = surface

    def best(self) -> WrittenLock:
        """Return the lock of the surface itself in the frame where it is highest."""
        frames = self._turns(self._surface.frame)
        return max((self._read(self._surface.points, frame) for frame in frames), key=lambda lock: lock.score)

    def like(self, lock: WrittenLock, points: FloatArray) -> WrittenLock:
        """Return the lock of the surface with these points, in the frame most like that of another lock."""
        frames = self._turns(canonical_frame(points, self._surface.faces))
        nearest = max(frames, key=lambda each: float(np.einsum("ij,ij->", each.axes, lock.frame.axes)))
        return self._read(points, nearest)

    @abstractmethod
    def _turns(self, frame: Frame) -> list[Frame]:
        """Return the frames that the surface may have had."""

    @abstractmethod
    def _read(self, points: FloatArray, frame: Frame) -> WrittenLock:
        """Return the lock of the surface with these points in a frame."""


class _CellReader(WrittenReader):
    """Reads cells."""

    def __init__(self, surface: Surface, key: Key, certificate: Certificate) -> None:
        super().__init__(surface)
        self._step = certificate.step
        self._lattice = Lattice.keyed(key, certificate.spacing, Label.of_hex(certificate.lattice))
        canonical = surface.frame.to_canonical(surface.points)
        self._sampler = plan_samples(canonical, surface.faces, LONGEST_SAMPLE * certificate.spacing)

    def _turns(self, frame: Frame) -> list[Frame]:
        return list(frame_alternatives(frame, surely_skew=SURELY_SKEW))

    def _read(self, points: FloatArray, frame: Frame) -> WrittenLock:
        samples = self._sampler(frame.to_canonical(points))
        cells = read_cells(samples, self._lattice, Pose.turned(np.eye(3)))
        keys = self._lattice.keys(cells.nodes)
        phase = bit_phase(cells.offset, keys.dither, self._step)
        return WrittenLock(frame=frame, nodes=cells.nodes, phase=phase)


class _PointReader(WrittenReader):
    """Reads points."""

    def __init__(self, surface: Surface, key: Key, certificate: Certificate) -> None:
        super().__init__(surface)
        self._step = float(STEPS[step_number(certificate.step * SIDE)])
        self._lattice = PointLattice.keyed(key, Label.of_hex(certificate.lattice))

    def _turns(self, frame: Frame) -> list[Frame]:
        return list(frame_alternatives(frame, True, SURELY_SKEW))

    def _read(self, points: FloatArray, frame: Frame) -> WrittenLock:
        surface = self._surface.moved(points)
        framed = Framed.of(surface, Carried.of(surface, frame), frame, self._lattice)
        lock = framed.best_at(self._step)
        carries = framed.carrying(lock)
        place = np.stack([*np.nonzero(carries), np.zeros(np.count_nonzero(carries), np.int64)], axis=1)
        return WrittenLock(frame=frame, nodes=place, phase=framed.phases(lock.step)[carries])


def reader_of(surface: Surface, key: Key, certificate: Certificate) -> WrittenReader:
    """Return what reads a surface by a certificate that is bound to a key."""
    reader = _PointReader if certificate.at_points else _CellReader
    return reader(surface, key, certificate)
