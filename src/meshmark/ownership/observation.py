"""What one reading shows of each cell: its phase, where it lies, what the key says of it, how rough it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import CellKeys
from meshmark.ownership.carriers.relief import Relief

__all__ = ["Observation"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Observation:
    """n cells read with a quantisation step in spacings; phase: (n,) radians, relief: of the surface."""

    phase: FloatArray
    cells: Cells
    keys: CellKeys
    step: float
    relief: Relief

    def __len__(self) -> int:
        return len(self.phase)

    @property
    def psi(self) -> FloatArray:
        """Return the phases (n,) that do not depend on bits: single of pilots, doubled of all others."""
        return np.asarray(self.keys.factor * self.phase)
