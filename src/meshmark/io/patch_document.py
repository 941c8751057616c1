"""The document of OFF, OBJ, PLY and STL: coordinates that can be patched, faces, and what else is known."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from meshmark.document import Attributes, Deviation
from meshmark.errors import FormatError
from meshmark.io.gaps import Gaps
from meshmark.io.paint import Paint
from meshmark.io.polygons import check_indices
from meshmark.mesh import FloatArray, IntArray

__all__ = ["PatchDocument", "Positions", "patch_document"]


class Positions(Protocol):
    """Coordinates that stand somewhere in a file."""

    @property
    def values(self) -> FloatArray:
        """Return the (n, 3) positions read."""
        ...

    def conform(self, vertices: FloatArray) -> FloatArray:
        """Return the (n, 3) positions that the file would hold for these."""
        ...

    def patch(self, vertices: FloatArray) -> bytes:
        """Return the file with the changed coordinates in place."""
        ...

    def describe(self) -> str:
        """Return how the file stores numbers, in words."""
        ...


@dataclass(frozen=True, eq=False, kw_only=True)
class PatchDocument:
    """A one-file document; see `meshmark.document.Document`.

    load_attributes: reads the attributes when a conversion asks for them. shown_too: what viewers show beside the
    surface. load_paint: reads what the triangles are painted with when a picture is drawn; None for formats without
    materials.
    """

    format: str
    positions: Positions
    faces: IntArray
    load_attributes: Callable[[], Attributes]
    facts: Mapping[str, Any] = field(default_factory=dict)
    references: tuple[Path, ...] = ()
    remarks: tuple[str, ...] = ()
    shown_too: tuple[Deviation, ...] = ()
    load_paint: Callable[[], Paint | None] | None = None

    @property
    def vertices(self) -> FloatArray:
        """Return the (n, 3) positions read."""
        return self.positions.values

    def conform(self, vertices: FloatArray) -> FloatArray:
        """Return the (n, 3) positions that the file would hold for these."""
        return self.positions.conform(np.asarray(vertices, dtype=np.float64))

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        """Return the one file to write, changed coordinates in place."""
        return {name: self.positions.patch(np.asarray(vertices, dtype=np.float64))}

    def attributes(self) -> Attributes:
        """Return what a conversion to another format may keep."""
        return self.load_attributes()

    def summary(self) -> dict[str, Any]:
        """Return what `meshmark info` prints beside counts."""
        return {"precision": self.positions.describe(), **self.facts}

    def deviations(self) -> tuple[Deviation, ...]:
        """Return in which ways a viewer shows something else than the surface."""
        return self.shown_too

    def looks(self) -> tuple[str, ...] | None:
        """Return None: materials are not read."""
        return None

    def side_files(self) -> tuple[Path, ...]:
        """Return existing files that the file refers to."""
        return self.references


def patch_document(
    format: str,
    positions: Positions,
    faces: IntArray,
    load_attributes: Callable[[], Attributes],
    *,
    facts: Mapping[str, Any],
    references: tuple[Path, ...] = (),
    remarks: tuple[str, ...] = (),
    gaps: Gaps | None = None,
    shown_too: tuple[Deviation, ...] = (),
    load_paint: Callable[[], Paint | None] | None = None,
) -> PatchDocument:
    """Check what was read, and return its document.

    faces and attributes count the vertices of the file, and `gaps` are those of them that `positions` leaves out.
    Raises `FormatError` where there is no face, or a face refers to a vertex that is not there or not finite.
    """
    if not len(faces):
        raise FormatError("the file has no faces, expected a surface (point clouds carry no mark)")
    check_indices(faces, len(positions.values) if gaps is None else gaps.total)
    if gaps is not None:
        faces, remarks = gaps.faces(faces), (*remarks, gaps.remark)
        load_attributes = partial(gaps.attributes, load_attributes)
    return PatchDocument(
        format=format,
        positions=positions,
        faces=faces,
        load_attributes=load_attributes,
        facts=facts,
        references=references,
        remarks=remarks,
        shown_too=shown_too,
        load_paint=load_paint,
    )
