"""The mark of the ownership layer: an id in the cells of a keyed lattice, or in the points of a surface."""

from __future__ import annotations

from dataclasses import dataclass

from meshmark.ownership.carriers.lattice_label import Label

__all__ = ["OwnershipMark"]


@dataclass(frozen=True, kw_only=True)
class OwnershipMark:
    """A mark of the ownership layer that was read back.

    carriers: number of cells, or of coordinates of points, that an extraction reads. label, spacing: of the
    lattice, in canonical units. step: of the quantisation, in spacings. at_points: the carriers are points instead
    of cells. repeated_only: the mark lies only in the part of the scene that is shown more than once.
    """

    carriers: int
    label: Label
    spacing: float
    step: float
    at_points: bool = False
    repeated_only: bool = False
