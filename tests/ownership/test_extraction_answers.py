"""What extraction answers where marks meet: docs/answers.md, checked."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.marking import embed, extract
from meshmark.mesh import Mesh
from tests.shapes import boulder, pebble

KEY, OTHER = Key(bytes(range(32))), Key(bytes(range(1, 33)))


@pytest.fixture(scope="module")
def model():
    return Mesh(*pebble(84))


@pytest.fixture(scope="module")
def marked(model):
    return embed(model, KEY, id=1, layers="ownership").mesh


@pytest.fixture(scope="module")
def second(model):
    return embed(model, KEY, id=2, layers="ownership").mesh


def test_two_copies_with_two_ids_are_told_apart(marked, second):
    assert (extract(marked, KEY).id, extract(second, KEY).id) == (1, 2)


def test_a_mark_of_another_key_leaves_the_first():
    marked = embed(Mesh(*boulder(90)), KEY, id=1, layers="ownership", strength="strong").mesh
    both = embed(marked, OTHER, id=3, layers="ownership").mesh
    assert (extract(both, KEY).id, extract(both, OTHER).id) == (1, 3)


def test_a_mark_of_the_same_key_replaces_the_first(marked):
    assert extract(embed(marked, KEY, id=9, layers="ownership").mesh, KEY).id == 9


def test_a_mirror_image_is_read_and_called_so(marked):
    mirrored = Mesh(marked.vertices * [1.0, 1.0, -1.0], marked.faces[:, ::-1])
    found = extract(mirrored, KEY)
    assert (found.presence, found.id) == ("present", 1)
    assert "mirror" in found.advice
    assert "mirror" not in extract(marked, KEY).advice


def test_an_average_of_two_ids_never_reads_as_a_third(model, marked, second):
    found = extract(Mesh((marked.vertices + second.vertices) / 2.0, model.faces), KEY)
    assert found.id in (None, 1, 2)


def test_among_issued_ids_one_is_told_that_all_ids_together_hide(model, marked):
    diagonal = np.linalg.norm(np.ptp(model.vertices, axis=0))
    noise = 6e-4 * diagonal * np.random.default_rng(3).normal(size=model.vertices.shape)
    suspect = Mesh(marked.vertices + noise, model.faces)
    assert extract(suspect, KEY, search="plain").ids == ()
    found = extract(suspect, KEY, search="plain", among=range(1, 9))
    assert (found.presence, found.id, found.ids) == ("present", 1, (1,))
    assert found.log10_false_positive <= -6.0
    assert extract(suspect, KEY, search="plain", among=range(2, 9)).ids == ()
    assert extract(model, KEY, search="plain", among=range(1, 9)).presence == "absent"
