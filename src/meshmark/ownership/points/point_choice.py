"""How points carry: the step, how many coordinates of each, and which share of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.mesh import FloatArray
from meshmark.ownership.points.parameters import KEPT_SHARE, MODES, SHARES, STEPS

__all__ = ["Choice", "cuts_of", "step_number"]


@dataclass(frozen=True, kw_only=True)
class Choice:
    """How points carry.

    step: in canonical units. mode: index of `MODES`. share: of the coordinates that carry, one of `SHARES`.
    """

    step: float
    mode: int
    share: float

    @property
    def cut(self) -> float:
        """Return the draw below which a coordinate carries."""
        return self.share * (KEPT_SHARE if self.mode == len(MODES) - 1 else 1.0)

    def carrying(
        self, coordinates: NDArray[np.bool_], room: NDArray[np.bool_], draw: FloatArray
    ) -> NDArray[np.bool_]:
        """Return (p, 3): the coordinates that carry.

        coordinates: (p, 3) those of the mode. room: (p,) where there is some for the step. draw: (p, 3) of the
        keys.
        """
        return np.asarray(coordinates & room[:, None] & (draw < self.cut))


def cuts_of(mode: int) -> list[float]:
    """Return the draw below which coordinates carry for each of `SHARES` of a mode."""
    return [Choice(step=1.0, mode=mode, share=share).cut for share in SHARES]


def step_number(step: float) -> int:
    """Return the number, among `STEPS`, of the one that is nearest to a step in canonical units."""
    return int(np.argmin(np.abs(STEPS - step)))
