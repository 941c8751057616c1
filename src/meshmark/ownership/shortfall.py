"""Why a model cannot carry the id, from what was counted on its surface, and what would help."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from meshmark.geometry.areas import face_areas, face_lengths
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.cells import PLANE_MASS, Cells
from meshmark.ownership.parameters import CARRIER_MINIMUM, EXTRACT_SELECTION

__all__ = ["Counted", "Surroundings", "too_long", "what", "why_not"]

_SUBDIVIDE = "subdividing it once or twice first helps"
_STRONGER = {"subtle": "standard", "standard": "strong"}


@dataclass(frozen=True, eq=False, kw_only=True)
class Surroundings:
    """What the cells of a lattice see of a surface; measured when it is asked for.

    cells: all of the lattice. placed: (p, 3) points of the surface in lattice coordinates; faces: (m, 3).
    """

    cells: Cells = field(repr=False)
    placed: FloatArray = field(repr=False)
    faces: IntArray = field(repr=False)

    @property
    def folded(self) -> float:
        """Share of the surface, 0 to 1, in cells where faces point in too many directions."""
        return self._shares[0]

    @property
    def scattered(self) -> float:
        """Share of the surface, 0 to 1, in cells that hold too little of it."""
        return self._shares[1]

    @cached_property
    def doubled(self) -> float:
        """Share in faces that are there more than once, as those of models with an inner and an outer side are."""
        ordered = np.sort(self.faces, axis=1)
        _, place, times = np.unique(ordered, axis=0, return_inverse=True, return_counts=True)
        return _mean((times[place.reshape(-1)] > 1).astype(np.float64), face_areas(self.placed, self.faces))

    @cached_property
    def longest(self) -> float:
        """Mean over the surface of the longest edge of a face, in spacings."""
        return _mean(face_lengths(self.placed, self.faces), face_areas(self.placed, self.faces))

    @cached_property
    def _shares(self) -> tuple[float, float]:
        cells, (mass, flatness, offset) = self.cells, EXTRACT_SELECTION
        # Where all fluxes cancel, mass and flatness are both 0, and how much surface there is cannot be told.
        flat = cells.flatness > 0.0
        surface = np.divide(cells.mass * PLANE_MASS, cells.flatness, out=np.zeros(len(flat)), where=flat)
        folded = cells.flatness <= flatness
        # Of a cell beside the surface another one has the surface in its middle.
        counted = folded | (np.abs(cells.offset) < offset)
        total = max(float(surface[counted].sum()), np.finfo(float).tiny)
        scattered = counted & ~folded & (cells.mass <= mass)
        return float(surface[folded].sum()) / total, float(surface[scattered].sum()) / total


@dataclass(frozen=True, kw_only=True)
class Counted:
    """An id of so many bits at a strength, and carriers: cells that can be set, of `capacity` that are read."""

    bits: int
    carriers: int
    capacity: int
    strength: str


def what(bits: int) -> str:
    """Return what a model cannot carry, in words."""
    return f"{bits} bits" if bits else "a mark of presence"


def too_long(longest: float, bits: int, strength: str) -> str:
    """Return the sentence for a surface whose triangles are so long that its cells cannot be set."""
    text = f"the model cannot carry {what(bits)} at strength {strength} in even patches of its surface"
    return f"{text}: its triangles are {longest:.1f} times as long as a patch is wide"


def _mean(values: FloatArray, areas: FloatArray) -> float:
    return float(values @ areas) / max(float(areas.sum()), np.finfo(float).tiny)


def why_not(found: Surroundings, counted: Counted, tried: bool) -> str:
    """Return the sentence of a refusal; tried: with marks that were not read."""
    carriers, capacity, strength = counted.carriers, counted.capacity, counted.strength
    least = CARRIER_MINIMUM[counted.bits]
    text = (
        f"the model cannot carry {what(counted.bits)} at strength {strength}: it needs about {least} carriers"
    )
    if capacity < least:
        return f"{text} (even patches of the surface), has {capacity}; {_uneven(found)}"
    if not tried:
        return (
            f"{text} that can be set, has {carriers} among {capacity}; {_long(found)}, {_SUBDIVIDE}, more strength "
            "does not"
        )
    text = f"{text} that hold their bits, has {carriers} of which too few do"
    if found.longest > 1.0:
        text += f"; {_long(found)}, {_SUBDIVIDE}"
    stronger = _STRONGER.get(strength)
    return f"{text}; --strength {stronger} was not tried" if stronger else text


def _uneven(found: Surroundings) -> str:
    if found.doubled > 0.5:
        return (
            f"{found.doubled:.0%} of the surface is there twice, with faces that point both ways; removing the "
            "doubled faces helps, more strength does not"
        )
    if found.folded >= found.scattered:
        return (
            f"{found.folded:.0%} of the surface has faces that point every way within one patch, as foliage, thin "
            "sheets and close assemblies have; marking its smooth parts alone may help, more strength does not"
        )
    return (
        f"{found.scattered:.0%} of the surface is in parts too small or too narrow for a patch; marking its larger "
        "parts alone may help, more strength does not"
    )


def _long(found: Surroundings) -> str:
    if found.longest > 1.0:
        return f"its triangles are {found.longest:.1f} times as long as a patch is wide"
    return "it has too few points for them"
