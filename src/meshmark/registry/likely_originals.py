"""Which originals of a registry a suspect may be a copy of: those whose shape its own is a part of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from meshmark.geometry.surface import Surface
from meshmark.registry.registry import Registry
from meshmark.registry.shape_descriptor import containment, described_at_sizes, shapes_of

__all__ = ["MOST_CANDIDATES", "Candidate", "candidates"]

MOST_CANDIDATES: Final = 10
"""Originals that a suspect is compared with; of those of its own shape, recall is measured among this number."""


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """An original that a suspect may be a copy of.

    digest: its own; likeness: 0 to 1, 1 for the same shape; size: its size over the suspect's, about.
    """

    digest: str
    name: str
    likeness: float
    size: float


def candidates(
    registry: Registry, suspect: Surface, key: str, most: int = MOST_CANDIDATES
) -> list[Candidate]:
    """Return the originals that a suspect is likeliest to be a copy or a part of, likeliest first.

    Parameters
    ----------
    registry : Registry
    suspect : Surface
    key : str
        Public fingerprint: originals without copies of this key are left out.
    most : int
        Largest number of originals returned.

    Returns
    -------
    list of Candidate
        Originals of unknown shape have likeness 0 and come last.

    Raises
    ------
    RegistryError
        The registry cannot be read.
    """
    known = registry.shapes(key)
    scores, sizes = containment(
        shapes_of([descriptor for _, _, descriptor in known]), described_at_sizes(suspect)
    )
    return [
        Candidate(
            digest=known[row][0], name=known[row][1], likeness=float(scores[row]), size=float(sizes[row])
        )
        for row in np.argsort(-scores, kind="stable")[:most]
    ]
