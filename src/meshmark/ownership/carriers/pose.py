"""A small correction of the canonical frame, and how the cells' offsets follow it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import Lattice

__all__ = ["POSE_SIZE", "Pose", "moved_along", "pose_gradient"]

# shift (3), logarithm of scale (1), turn (3)
POSE_SIZE = 7


@dataclass(frozen=True, eq=False, kw_only=True)
class Pose:
    """The similarity X -> scale X turn + shift of canonical coordinates; turn (3, 3) is a rotation."""

    turn: FloatArray
    scale: float
    shift: FloatArray

    @classmethod
    def turned(cls, turn: FloatArray) -> Pose:
        """Only a turn."""
        return cls(turn=turn, scale=1.0, shift=np.zeros(3))

    def __call__(self, points: FloatArray) -> FloatArray:
        """Return points (p, 3) brought to this pose."""
        return np.asarray(self.scale * points @ self.turn + self.shift)

    def then(self, step: FloatArray) -> Pose:
        """This pose followed by a small one (7,): shift, logarithm of scale, rotation vector."""
        turn = _rotation(step[4:7]).T
        scale = float(np.exp(step[3]))
        return Pose(
            turn=self.turn @ turn, scale=self.scale * scale, shift=scale * self.shift @ turn + step[:3]
        )


def pose_gradient(cells: Cells, lattice: Lattice) -> FloatArray:
    """Return (n, 7): change of each offset, in spacings, per unit of a small pose (docs/design.md, section 4).

    A patch at p with normal N moves by shift + scale p + turn x p; its offset by the part along N.
    """
    normal = cells.normal @ lattice.axes
    place = (
        lattice.points(cells.nodes.astype(np.float64)) + normal * (cells.offset * lattice.spacing)[:, None]
    )
    return moved_along(place, normal) / lattice.spacing


def moved_along(places: FloatArray, directions: FloatArray) -> FloatArray:
    """Return (n, 7): how far places (n, 3) move along directions (n, 3), per unit of a small pose."""
    along = np.einsum("ij,ij->i", directions, places)
    return np.column_stack([directions, along, np.cross(places, directions)])


def _rotation(vector: FloatArray) -> FloatArray:
    """Return the rotation matrix (3, 3) of a rotation vector (3,), radians (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    first = np.sinc(angle / np.pi)  # sin(a) / a
    second = 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2  # (1 - cos a) / a^2
    return np.asarray(np.eye(3) + first * cross + second * cross @ cross)
