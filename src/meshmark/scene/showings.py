"""The showings of meshes in a scene: which of them is taken for each mesh, and the maps between them."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from meshmark.geometry.components import connected_components
from meshmark.geometry.copies import FIRST_LARGEST
from meshmark.io.placement import Affine, Placement
from meshmark.mesh import IntArray

__all__ = ["faces_once", "maps_between", "placement_ranks"]


def placement_ranks(slots: IntArray, showing: IntArray, placements: tuple[Placement, ...]) -> IntArray:
    """Return the rank of each placement; what two of them show is taken from the one of lower rank."""
    count = len(placements)
    links = csr_array(
        (np.ones(len(slots), np.int8), (showing, slots + count)),
        shape=(count + int(slots.max()) + 1,) * 2,
    )
    group = connected_components(links)[1][:count]
    scale = np.array([abs(np.linalg.det(item.affine.linear)) ** (1 / 3) for item in placements])
    largest = np.zeros(int(group.max()) + 1)
    np.maximum.at(largest, group, scale)
    share = scale / largest[group]
    share[share >= FIRST_LARGEST] = 1.0
    rank = np.empty(count, np.int64)
    rank[np.argsort(-share, kind="stable")] = np.arange(count)
    return rank


def faces_once(faces: IntArray, rank: IntArray) -> IntArray:
    """Return the faces (m, 3) without those that a placement of lower rank shows, too; rank: (m,)."""
    start = faces.argmin(axis=1)
    keys = faces[np.arange(len(faces))[:, None], (start[:, None] + np.arange(3)) % 3]
    order = np.lexsort((rank, keys[:, 2], keys[:, 1], keys[:, 0]))
    new = np.ones(len(faces), bool)
    new[1:] = (keys[order[1:]] != keys[order[:-1]]).any(axis=1)
    lowest = rank[order][np.flatnonzero(new)][np.cumsum(new) - 1]
    kept = np.zeros(len(faces), bool)
    kept[order] = rank[order] == lowest
    return np.asarray(faces[kept])


def maps_between(
    showing: IntArray, source: IntArray, placements: tuple[Placement, ...]
) -> dict[tuple[int, int], Affine]:
    """Return the map from original to image of each pair (image, original) of placements that a vertex has."""
    count = len(placements)
    pairs = [divmod(int(value), count) for value in np.unique(showing * count + showing[source])]
    inverse = {one: placements[one].affine.inverse() for one in {pair[1] for pair in pairs}}
    same = Affine.identity()
    return {
        (image, one): same if image == one else placements[image].affine.after(inverse[one])
        for image, one in pairs
    }
