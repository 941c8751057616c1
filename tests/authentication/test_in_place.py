"""Marks that say where they lie: of many small parts the largest one alone may suit a wrong place as well."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from meshmark.authentication.checks.in_place import in_place
from meshmark.authentication.checks.model_frame import Evidence, fit_frame
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
    return Evidence(
        vertex=np.arange(len(part)),
        centre=suspect,
        direction=direction,
        value=value,
        step=np.full(len(part), STEP),
        period=np.full(len(part), np.inf),
    )


def believed(found: Evidence) -> np.ndarray:
    """Return which marks are believed where each part is a fan of its own around its first mark."""
    count = len(found.vertex)
    first = np.arange(count) // EACH * EACH
    pairs = np.stack([np.arange(count), first], axis=1)
    edges = unique_edges(np.stack([np.arange(count), first, first], axis=1))
    return in_place(edges, np.ones(count, bool), pairs, np.zeros(count, bool), found).believed


@pytest.mark.parametrize("seed", range(30))
def test_parts_that_lie_in_their_places_are_believed(seed):
    assert believed(evidence(seed)).all()


@pytest.mark.parametrize("seed", range(30))
def test_a_part_that_was_moved_is_not(seed):
    right = believed(evidence(seed, moved=11))
    assert not right[11 * EACH : 12 * EACH].any()
    assert right.sum() == (PARTS - 1) * EACH


FINE, PERIOD = 2.0**-15, 2.0**-5
SMALL, LARGE = 8, 200


def two_parts(seed: int, shift: float = 0.0, degrees: float = 0.0) -> Evidence:
    """Return marks of a large part and a small one, half of them fine; the small one was shifted and turned."""
    random = np.random.default_rng(seed)
    part = np.repeat([0, 1], [LARGE, SMALL])
    spread = np.where(part == 0, 0.5, 0.2)[:, None]
    home = spread * random.uniform(-1.0, 1.0, size=(len(part), 3)) + part[:, None] * [0.6, 0.2, 0.0]
    direction = random.normal(size=home.shape)
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    fine = np.arange(len(part)) % 2 == 1
    step, period = np.where(fine, FINE, STEP), np.where(fine, PERIOD, np.inf)
    along = np.einsum("ei,ei->e", home, direction)
    told = np.where(fine, along % PERIOD, along)
    value = (np.floor(told / step) + 0.5) * step
    way = random.normal(size=3)
    way /= np.linalg.norm(way)
    middle = home[part == 1].mean(axis=0)
    turned = (
        (home - middle) @ Rotation.from_rotvec(np.radians(degrees) * way).as_matrix().T + middle + shift * way
    )
    suspect = 17.0 * np.where((part == 1)[:, None], turned, home) @ rotation(bytes([seed]) * 32).T + 3.0
    return Evidence(
        vertex=np.arange(len(part)),
        centre=suspect,
        direction=direction,
        value=value,
        step=step,
        period=period,
    )


def small_part_believed(found: Evidence) -> bool:
    count = len(found.vertex)
    first = np.repeat([0, LARGE], [LARGE, SMALL])
    pairs = np.stack([np.arange(count), first], axis=1)
    edges = unique_edges(np.stack([np.arange(count), first, first], axis=1))
    right = in_place(edges, np.ones(count, bool), pairs, np.zeros(count, bool), found).believed
    assert right[:LARGE].all()
    return bool(right[LARGE:].any())


@pytest.mark.parametrize("seed", range(30))
def test_a_part_that_lies_in_its_place_is_believed_by_its_fine_marks_too(seed):
    assert small_part_believed(two_parts(seed))


def test_a_loose_part_that_was_moved_a_little_is_not():
    """By 0.1 % of the diagonal (0.002 of half of it), or turned by 0.1 degrees."""
    assert sum(small_part_believed(two_parts(seed, shift=0.002)) for seed in range(60)) <= 3
    assert sum(small_part_believed(two_parts(seed, degrees=0.1)) for seed in range(60)) <= 3


def test_fine_marks_make_the_frame_precise():
    found = two_parts(3)
    rough = two_parts(3)
    everything = np.ones(len(found.vertex), bool)
    precise = fit_frame(found, everything)
    only_coarse = fit_frame(rough, ~rough.fine)
    assert precise is not None
    assert only_coarse is not None
    assert precise.off(found)[found.fine].max() < FINE
    assert precise.scale.doubt < 0.1 * only_coarse.scale.doubt
    assert precise.scale.half == pytest.approx(17.0, rel=1e-5)


def test_a_mark_far_from_where_it_says_is_not_believed_though_its_part_is():
    found = two_parts(5)
    found.value[4] += 0.3
    count = len(found.vertex)
    first = np.repeat([0, LARGE], [LARGE, SMALL])
    pairs = np.stack([np.arange(count), first], axis=1)
    edges = unique_edges(np.stack([np.arange(count), first, first], axis=1))
    right = in_place(edges, np.ones(count, bool), pairs, np.zeros(count, bool), found).believed
    assert np.flatnonzero(~right).tolist() == [4]
