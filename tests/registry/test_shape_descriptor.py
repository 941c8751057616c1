"""The descriptor of a shape: what it does not see, and that parts are found in their wholes."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import ATTACKS
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.registry.shape_descriptor import (
    Shapes,
    containment,
    described,
    described_at_sizes,
    shapes_of,
)
from meshmark.registry.shape_words import WORDS, words
from tests.shapes import hoop, pebble


def shapes() -> list[Mesh]:
    """Return twelve shapes that differ: a pebble with other bumps each, and a ring."""
    points, faces = pebble(40)
    made = []
    for seed in range(11):
        rng = np.random.default_rng(seed)
        waves, phases = rng.normal(scale=2.0, size=(6, 3)), rng.uniform(0.0, 6.0, 6)
        bumps = 1.0 + 0.12 * np.sin(points @ waves.T + phases).sum(axis=1)
        made.append(Mesh(points * bumps[:, None] * rng.uniform(0.6, 1.6, 3), faces))
    return [*made, Mesh(*hoop(60, 12, 0.2))]


@pytest.fixture(scope="module")
def known() -> tuple[list[Mesh], Shapes]:
    meshes = shapes()
    return meshes, shapes_of([described(surface_of(mesh)) for mesh in meshes])


def place_of(row: int, suspect: Mesh, matrix: Shapes) -> int:
    """Return how many shapes are likelier to be the whole of a suspect than that of a row."""
    scores, _ = containment(matrix, described_at_sizes(surface_of(suspect)))
    assert ((scores >= 0.0) & (scores <= 1.0 + 1e-6)).all()
    return int((scores > scores[row]).sum())


def test_a_descriptor_is_short_and_always_the_same(known):
    meshes, matrix = known
    first = described(surface_of(meshes[0]))
    assert len(first) == WORDS + 5
    assert first == described(surface_of(Mesh(meshes[0].vertices, meshes[0].faces)))
    assert matrix.areas.shape == (12, WORDS)
    assert matrix.areas.max(axis=1).min() == 255


def test_the_words_are_the_same_on_every_machine():
    """The first numbers, as the inverse of the normal distribution of `statistics` gives them."""
    from hashlib import shake_256
    from statistics import NormalDist

    drawn = shake_256(b"meshmark shape words 1").digest(8)
    uniform = [(int.from_bytes(drawn[i : i + 4], "little") + 0.5) / 2**32 for i in (0, 4)]
    first, second = (NormalDist().inv_cdf(value) for value in uniform)
    assert words()[0, :2] == pytest.approx([first, -0.26 * first + 0.96 * second], abs=1e-9)


@pytest.mark.parametrize(
    ("attack", "strength", "most"),
    [
        ("similarity", 1, 0), ("shuffle", 1, 0), ("midpoint", 1, 0), ("noise", 0.02, 0), ("simplification", 0.5, 0),
        ("crop", 0.1, 2), ("crop", 0.3, 9),
    ],
)  # fmt: skip
def test_what_was_done_to_a_copy_does_not_hide_its_original(known, attack, strength, most):
    meshes, matrix = known
    for row in (0, 7):
        rng = np.random.default_rng(row)
        suspect = ATTACKS["similarity"](ATTACKS[attack](meshes[row], strength, rng), 1, rng)
        assert place_of(row, suspect, matrix) <= most


def test_shapes_that_are_not_known_come_last(known):
    meshes, _ = known
    matrix = shapes_of([None, b"short", bytes([9]) + bytes(WORDS + 4), described(surface_of(meshes[3]))])
    scores, sizes = containment(matrix, described_at_sizes(surface_of(meshes[3])))
    assert (scores[:3] == 0.0).all()
    assert scores[3] > 0.9
    assert sizes[3] == 1.0


def test_a_registry_without_shapes_has_no_candidates():
    scores, sizes = containment(shapes_of([]), np.ones((2, WORDS)))
    assert scores.shape == sizes.shape == (0,)
