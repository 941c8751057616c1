"""Marks that say where they lie: of many small parts the largest one alone may suit a wrong place as well."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.checks.in_place import Evidence, in_place
from meshmark.coding.keyed import rotation
from meshmark.geometry.adjacency import unique_edges

STEP = 2.0**-9
PARTS, EACH = 30, 13


def evidence(seed: int, moved: int | None = None) -> Evidence:
    """Return marks of small parts all over a model, turned, scaled and shifted; part `moved` lies elsewhere."""
    random = np.random.default_rng(seed)
    part = np.repeat(np.arange(PARTS), EACH)
    middle = random.uniform(-0.55, 0.55, size=(PARTS, 3))
    home = middle[part] + random.normal(size=(len(part), 3)) * [0.02, 0.015, 0.01]
    direction = random.normal(size=home.shape)
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    value = (np.floor(np.einsum("ei,ei->e", home, direction) / STEP) + 0.5) * STEP
    place = home + (part == moved)[:, None] * np.array([0.2, -0.1, 0.15])
    suspect = 17.0 * place @ rotation(bytes([seed]) * 32).T + 3.0
    return Evidence(vertex=np.arange(len(part)), centre=suspect, direction=direction, value=value, step=STEP)


def believed(found: Evidence) -> np.ndarray:
    """Return which marks are believed where each part is a fan of its own around its first mark."""
    count = len(found.vertex)
    first = np.arange(count) // EACH * EACH
    pairs = np.stack([np.arange(count), first], axis=1)
    edges = unique_edges(np.stack([np.arange(count), first, first], axis=1))
    return in_place(edges, np.ones(count, bool), pairs, np.zeros(count, bool), found)[0]


@pytest.mark.parametrize("seed", range(30))
def test_parts_that_lie_in_their_places_are_believed(seed):
    assert believed(evidence(seed)).all()


@pytest.mark.parametrize("seed", range(30))
def test_a_part_that_was_moved_is_not(seed):
    right = believed(evidence(seed, moved=11))
    assert not right[11 * EACH : 12 * EACH].any()
    assert right.sum() == (PARTS - 1) * EACH
