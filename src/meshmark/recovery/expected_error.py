"""How far a miniature may be trusted: what it would make of parts that nobody altered."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.miniature_projection import MiniatureProjection, spreads

__all__ = ["expected_errors"]

# Number of intact parts that are measured, and their most points: of larger ones few points are near a boundary.
PROBES, LARGEST = 24, 4096


def expected_errors(
    points: FloatArray,
    graph: csr_array,
    intact: IntArray,
    mini: tuple[FloatArray, IntArray],
    sizes: IntArray,
) -> FloatArray:
    """Return (k,): the median RMS distance at which intact parts of `sizes` (k,) points lie off the miniature.

    It is corrected by the boundaries of these parts as it is by those of altered ones (`MiniatureProjection`), so
    this is what is left where an altered part is back in place. points: (p, 3); graph: (p, p) adjacency;
    intact: (i,) points; mini: points and faces in the same coordinates.
    """
    from scipy.sparse.csgraph import breadth_first_order

    inside, places = csr_array(graph[intact][:, intact]), points[intact]
    classes = np.minimum(2 ** np.round(np.log2(np.maximum(sizes, 1))).astype(np.int64), LARGEST)
    errors = np.zeros(len(sizes))
    for size in np.unique(classes):
        count = int(np.clip(len(intact) // (2 * size), 1, PROBES))
        probe = np.full(len(intact), -1)
        for number, seed in enumerate(np.arange(count) * (len(intact) // count)):
            near = breadth_first_order(inside, int(seed), directed=False, return_predecessors=False)
            probe[near[:size]] = number
        projection = MiniatureProjection(places, np.empty((0, 3), np.int64), inside, probe >= 0, mini)
        off = spreads(probe[probe >= 0], projection.distances() ** 2, count)
        errors[classes == size] = float(np.median(off[np.unique(probe[probe >= 0])]))
    return errors
