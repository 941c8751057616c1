"""Vertices without finite coordinates: kept in the file, left out of the surface, refused where a face uses one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from meshmark.document import Attributes
from meshmark.errors import FormatError
from meshmark.io.wording import amount
from meshmark.mesh import IntArray

__all__ = ["Gaps"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Gaps:
    """Rows of a file that are left out.

    kept:  (n,) ascending rows of the file that stay. total: its rows.
    say:   the sentence that refuses the file because of a row that is left out.
    """

    kept: IntArray
    total: int
    say: Callable[[int], str]

    @property
    def remark(self) -> str:
        """The clause that tells the user."""
        count = self.total - len(self.kept)
        vertices, stay = (
            amount(count, "vertex", "vertices"),
            "stays as it is" if count == 1 else "stay as they are",
        )
        return f"{vertices} without finite coordinates, used by no face, {stay}"

    @property
    def places(self) -> IntArray:
        """(total,) the new row of each row of the file, -1 for those left out."""
        places = np.full(self.total, -1, dtype=np.int64)
        places[self.kept] = np.arange(len(self.kept))
        return places

    def faces(self, faces: IntArray) -> IntArray:
        """Return faces (m, 3) in the rows that stay. Raises `FormatError` where one uses another."""
        renumbered = self.places[faces]
        if (renumbered < 0).any():
            raise FormatError(self.say(int(faces[renumbered < 0][0])))
        return renumbered

    def attributes(self, load: Callable[[], Attributes]) -> Attributes:
        """Return the attributes of the rows that stay."""
        found = load()
        chosen, seams = self.kept, None
        if found.seams is not None:
            points, faces = found.seams
            chosen = np.flatnonzero(self.places[points] >= 0)
            rank = np.cumsum(self.places[points] >= 0) - 1
            seams = (self.places[points][chosen], rank[faces])
        return replace(
            found,
            normals=None if found.normals is None else found.normals[chosen],
            texcoords=None if found.texcoords is None else found.texcoords[chosen],
            colors=None if found.colors is None else found.colors[chosen],
            seams=seams,
        )
