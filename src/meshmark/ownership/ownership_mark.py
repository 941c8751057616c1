"""The mark of the ownership layer: an id in the cells of a keyed lattice, or in the points of a surface."""

from __future__ import annotations

from dataclasses import dataclass, field

from meshmark.geometry.frame import Frame
from meshmark.ownership.carriers.lattice_label import Label

__all__ = ["OwnershipMark", "noise_borne"]

# A mark bears noise in proportion to its step, and about to this power of the number of code bits beyond those
# needed.
_NEEDED, _REDUNDANCY = {64: 85, 32: 54, 0: 12}, 0.5


def noise_borne(step: float, carried: float, bits: int = 64) -> float:
    """Return how much noise a mark of this step and this number of code bits bears, for an id of `bits`.

    In units that only compare marks of one surface, in cells or at points.
    """
    return float(step * max(carried - _NEEDED[bits], 0.0) ** _REDUNDANCY)


@dataclass(frozen=True, kw_only=True)
class OwnershipMark:
    """A mark of the ownership layer that was read back.

    carriers: number of cells, or of coordinates of points, that an extraction reads. frame: that it was made in.
    That of the marked surface differs a little, and may be another turn where the model is nearly symmetric. label,
    spacing: of the lattice, in canonical units. step: of the quantisation, in spacings. at_points: the carriers are
    points instead of cells. repeated_only: the mark lies only in the part of the scene that is shown more than
    once. bits: of the id, 64 or 32; 0: there is none. parts: numbers, among the `assembly_parts` of the surface, of
    those that carry the id on frames of their own besides.
    """

    carriers: int
    frame: Frame = field(repr=False, compare=False)
    label: Label
    spacing: float
    step: float
    at_points: bool = False
    repeated_only: bool = False
    bits: int = 64
    parts: tuple[int, ...] = ()

    @property
    def toughness(self) -> float:
        """Return about how much noise the mark bears (`noise_borne`)."""
        return noise_borne(self.step, self.carriers, self.bits)
