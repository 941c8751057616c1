"""One search for a mark: what is searched, with which key, how far, and what was tried so far."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from math import inf

from meshmark.certificate.certificate import Certificate
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label, labels
from meshmark.ownership.parameters import (
    DEAREST_LABEL,
    DEAREST_UNDONE,
    LABELS,
    LONG_EDGES,
    LONGEST_EDGES,
    LOW_PASSED_EDGES,
    preferred_spacings,
)
from meshmark.ownership.points.parameters import DEAREST_LABEL as DEAREST_AT_POINTS
from meshmark.ownership.points.parameters import MOST_POINTS
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.search.inverse_smoothing import LARGEST_AREA, shapes_before
from meshmark.ownership.search.trials import TrialCounter

__all__ = ["EFFORTS", "Search", "leaves_out_cells"]

EFFORTS = ("plain", "quick", "wide")
# A mesh with more points is no coarse one: what `restoration.py` undoes is enough there.
COARSE = 12_000


@dataclass(frozen=True, eq=False, kw_only=True)
class Search:
    """What every strategy is given.

    surface: of the suspect. effort: "plain" reads the surface as it stands (and where a reference says) only;
    "quick" also undoes common damage; "wide" also exchanges axes of nearly equal moments and reads every spacing.
    copies: further surfaces that may carry the mark, where a scene shows meshes several times (used up once).
    spacings: lattice spacings to read, None: all that an embedding may have chosen. reference: the certificate
    of the mark or the unmarked original. scales: of the reference over the suspect's, where they are known about.
    among: ids of which one may be there. label: of the lattice; None: found from the shape. trials: numbers every
    reading of this search. sure: an id whose word is less likely by chance than 10^this ends the search, others are
    kept for want of better; None: any id does.
    """

    surface: Surface
    key: Key
    effort: str = "quick"
    spacings: tuple[float, ...] | None = None
    reference: Certificate | Mesh | None = None
    scales: tuple[float, ...] = ()
    copies: Iterable[Surface] = ()
    among: tuple[int, ...] = ()
    label: Label | None = None
    sure: float | None = None
    trials: TrialCounter = field(default_factory=TrialCounter)

    @property
    def wide(self) -> bool:
        """Return whether everything is to be tried."""
        return self.effort == "wide"

    @property
    def is_coarse(self) -> bool:
        """Return whether the mesh is so coarse that its mark may lie in what restorations filter off."""
        return len(self.surface.points) <= COARSE

    @cached_property
    def has_cells(self) -> bool:
        """Return whether the surface may carry a mark in cells, even after a strong simplification."""
        if isinstance(self.reference, Certificate) and self.reference.at_points:
            return False
        return self._longest <= LONGEST_EDGES

    @property
    def bears_filters(self) -> bool:
        """Return whether what restorations filter off the surface leaves enough of a mark in cells."""
        return self._longest <= LOW_PASSED_EDGES

    @cached_property
    def suits_points(self) -> bool:
        """Return whether an embedding would have left out cells at once, so that points are read first."""
        if isinstance(self.reference, Certificate) and not self.reference.at_points:
            return False
        return leaves_out_cells(self.surface)

    @cached_property
    def before_smoothing(self) -> tuple[Surface, ...]:
        """The surfaces that this may have been before it was smoothed, without those that got too rough."""
        most = max(LARGEST_AREA * (10.0 if self.wide else 1.0), 2.0 * self.surface.frame.area)
        shapes = (self.surface.moved(points) for points in shapes_before(self.surface))
        return tuple(shape for shape in shapes if _frame_area(shape) < most)

    @cached_property
    def _longest(self) -> float:
        return _longest_edges(self.surface)

    @cached_property
    def _point_lattices(self) -> dict[Label, PointLattice]:
        return {}

    @cached_property
    def _lattices(self) -> dict[tuple[float, Label], Lattice]:
        return {}

    def labels(
        self, invariants: FloatArray, *, undone: bool = False, at_points: bool = False
    ) -> tuple[Label, ...]:
        """Return the labels of the lattices that a shape of these invariants may carry, likeliest first.

        undone: smoothing or a crop was taken back, not quite as it was. at_points: what carries are points, which
        bear less than cells.
        """
        if self.label is not None:
            return (self.label,)
        dearest = DEAREST_UNDONE if undone else DEAREST_LABEL
        if at_points and not self.wide:
            dearest = DEAREST_AT_POINTS
        return labels(invariants, self.key, LABELS[self.effort], dearest=dearest)

    def lattice(self, spacing: float, label: Label) -> Lattice:
        """Return the key's lattice of this spacing and label, one for the whole search."""
        name = spacing, label
        if name not in self._lattices:
            self._lattices[name] = Lattice.keyed(self.key, spacing, label)
        return self._lattices[name]

    def point_lattice(self, label: Label) -> PointLattice:
        """Return the key's cubes of points of this label, one for the whole search."""
        if label not in self._point_lattices:
            self._point_lattices[label] = PointLattice.keyed(self.key, label)
        return self._point_lattices[label]

    def spacings_for(self, area: float) -> Iterable[float]:
        """Return the spacings to read on a surface of this canonical area, likeliest first."""
        return preferred_spacings(area) if self.spacings is None else self.spacings


def leaves_out_cells(surface: Surface) -> bool:
    """Return whether an embedding tries points alone, as triangles are too long for cells."""
    return _longest_edges(surface) > LONG_EDGES[1] and len(surface.points) <= MOST_POINTS


def _longest_edges(surface: Surface) -> float:
    """Mean longest edge of the triangles, in lattice spacings."""
    frame = surface.frame
    return surface.mean_face_length / (preferred_spacings(frame.area)[0] * frame.scale)


def _frame_area(surface: Surface) -> float:
    """Return the area over the squared scale of the frame; infinite where that is beyond the range of numbers."""
    try:
        return surface.frame.area
    except InputError:
        return inf
