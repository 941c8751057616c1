"""Stored positions seen in the scene: transforms and instances, and the way back.

Formats with a scene (glTF, 3MF) store each position once and show it any number of times. A *placement*
is one such showing: which stored rows, under which affine map.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.affine import Affine
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Affine", "Placement", "place", "pull_back"]


@dataclass(frozen=True, eq=False)
class Placement:
    """Stored rows `slots`, (k,) indices, shown in the scene under the map `affine`."""

    slots: IntArray
    affine: Affine


def place(stored: FloatArray, placements: Sequence[Placement]) -> FloatArray:
    """Return the scene positions (n, 3) of all placements, one after the other, of stored rows (s, 3)."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.concatenate([item.affine(stored[item.slots]) for item in placements])


def pull_back(
    stored: FloatArray, placements: Sequence[Placement], before: FloatArray, after: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return where the stored rows should move to, (s, 3), and which of them move, (s,).

    A row shown several times moves by the mean of the displacements of its showings, each taken back
    through its own map. A row none of whose showings moved stays as it is, to the last bit.
    """
    total, shown = np.zeros_like(stored), np.zeros(len(stored))
    moved, start = np.zeros(len(stored), dtype=bool), 0
    for item in placements:
        rows = slice(start, start + len(item.slots))
        start += len(item.slots)
        shift = after[rows] - before[rows]
        moved[item.slots[(shift != 0).any(axis=1)]] = True
        if not item.affine.is_identity:
            shift = item.affine.undone(shift)
        # A placement may show one stored row twice, so plain fancy-index addition would lose some.
        for axis in range(3):
            total[:, axis] += np.bincount(item.slots, shift[:, axis], len(stored))
        shown += np.bincount(item.slots, minlength=len(stored))
    target = stored + total / np.maximum(shown, 1)[:, None]
    return np.where(moved[:, None], target, stored), moved
