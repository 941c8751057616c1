"""What one search reads: labels by how much damage the carriers bear."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.carriers.lattice_label import labels
from meshmark.ownership.parameters import DEAREST_LABEL
from meshmark.ownership.points.parameters import DEAREST_LABEL as DEAREST_AT_POINTS
from meshmark.ownership.search.search import Search
from tests.keys import KEY
from tests.shapes import pebble

SURFACE = surface_of(Mesh(*pebble(20)))


@pytest.fixture(scope="module")
def between() -> np.ndarray:
    """Invariants with a second label cheap enough for cells, and too dear for points."""
    rng = np.random.default_rng(0)
    for _ in range(1000):
        found = SURFACE.invariants + 0.02 * rng.normal(size=len(SURFACE.invariants))
        of_cells, of_points = (
            len(labels(found, KEY, 2, dearest=d)) for d in (DEAREST_LABEL, DEAREST_AT_POINTS)
        )
        if (of_cells, of_points) == (2, 1):
            return found
    raise AssertionError("no such invariants among 1000")


def test_points_are_read_under_fewer_labels_than_cells(between):
    search = Search(surface=SURFACE, key=KEY)
    first, *others = search.labels(between)
    assert others
    assert search.labels(between, at_points=True) == (first,)


def test_a_wide_search_reads_points_under_all_labels(between):
    search = Search(surface=SURFACE, key=KEY, effort="wide")
    assert search.labels(between, at_points=True) == search.labels(between)
