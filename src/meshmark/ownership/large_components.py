"""The connected components of a surface that are marked and read on their own: how large, and how many at most."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.components import connected_parts
from meshmark.geometry.surface import Surface

__all__ = ["LEAST_POINTS", "MOST_MARKED", "MOST_READ", "large_components"]

# With fewer points no component carries an id by itself, in points or in marks of authentication.
LEAST_POINTS: Final = 300
# Components that get the id once more: each takes about as long as the embedding of a model of its size.
MOST_MARKED: Final = 32
# Components of a suspect in which an id is looked for: each is charged, and costs time where nothing is there.
MOST_READ: Final = 8


def large_components(
    surface: Surface, most: int, chosen: NDArray[np.bool_] | None = None
) -> list[NDArray[np.bool_]]:
    """Return the components of at least `LEAST_POINTS` points, most points first.

    Parameters
    ----------
    surface : Surface
        Of p points.
    most : int
        Components at most, `MOST_MARKED` or `MOST_READ`.
    chosen : (p,) bool array, optional
        Only these points, and edges between them, are there; without it, those that faces use.

    Returns
    -------
    list of (p,) bool array
        The points of each; empty where all are one component.
    """
    label = connected_parts(surface.graph, surface.used if chosen is None else chosen)
    size = np.bincount(label[label >= 0], minlength=1)
    if len(size) < 2:
        return []
    largest = np.argsort(-size, kind="stable")[:most]
    return [label == each for each in largest if size[each] >= LEAST_POINTS]
