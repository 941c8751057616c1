"""A small correction of the canonical frame, and how the cells' offsets follow it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import Lattice

__all__ = ["POSE_SIZE", "Pose", "pose_gradient"]

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
    along = np.einsum("ij,ij->i", normal, place)
    return np.column_stack([normal, along, np.cross(place, normal)]) / lattice.spacing


def _rotation(vector: FloatArray) -> FloatArray:
    """Return the rotation matrix (3, 3) of a rotation vector (3,), radians (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    first = np.sinc(angle / np.pi)  # sin(a) / a
    second = 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2  # (1 - cos a) / a^2
    return np.asarray(np.eye(3) + first * cross + second * cross @ cross)
