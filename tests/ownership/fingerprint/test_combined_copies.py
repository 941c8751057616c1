"""Copies of one model put together: both ids of two are told, and no id that nobody has."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from meshmark.coding.codec import Codec
from meshmark.coding.keyed import rotation
from meshmark.errors import CapacityError
from meshmark.geometry.surface_of import surface_of
from meshmark.marking import Embedding, authenticate, embed, extract
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership import embedding
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.decoding import Found
from meshmark.ownership.extraction import find_copies
from meshmark.ownership.fingerprint.combined_copies import copies_of
from meshmark.ownership.fingerprint.parameters import LEAST_POINTS
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import TrialCounter
from meshmark.strengths import BUDGETS
from tests.keys import ID, KEY, OTHER, OTHER_ID
from tests.shapes import boulder

IDS = (ID, 7, OTHER_ID)
POINTS, FACES = boulder(104)
TOGETHER: dict[str, Callable[[FloatArray], FloatArray]] = {
    "average": lambda copies: copies.mean(axis=0),
    "minimum": lambda copies: copies.min(axis=0),
    "maximum": lambda copies: copies.max(axis=0),
}


@cache
def marked(identity: int) -> Embedding:
    return embed(Mesh(POINTS, FACES), KEY, id=identity)


def copies(count: int) -> FloatArray:
    """Return the positions (count, n, 3) of the first copies."""
    return np.array([marked(each).mesh.vertices for each in IDS[:count]])


def search_of(vertices: FloatArray, **options: object) -> Search:
    return Search(surface=surface_of(Mesh(vertices, FACES)), **{"key": KEY, "effort": "plain", **options})


def told(vertices: FloatArray, **options: object) -> Found | None:
    return copies_of(search_of(vertices, **options))


def test_the_shape_is_large_enough():
    assert len(POINTS) >= LEAST_POINTS


@pytest.mark.parametrize("identity", IDS)
def test_a_copy_tells_its_own_id(identity):
    found = told(marked(identity).mesh.vertices)
    assert (found.ids, found.combined) == ((identity,), False)
    assert found.log10_false_positive < -20.0
    assert max(found.log10_words) < -20.0


@pytest.mark.parametrize("name", TOGETHER)
def test_two_copies_put_together_tell_both_ids(name):
    suspect = TOGETHER[name](copies(2))
    found = told(suspect)
    assert found.ids == tuple(sorted(IDS[:2]))
    assert max(found.log10_words) < -7.0
    answer = extract(Mesh(suspect, FACES), KEY)
    assert (answer.presence, answer.id, set(answer.ids)) == ("present", None, set(IDS[:2]))


def test_an_average_that_was_turned_and_scaled_tells_both_ids():
    moved = TOGETHER["average"](copies(2)) @ rotation(b"elsewhere" * 4).T * 12.0 + [3.0, -1.0, 2.0]
    assert told(moved.astype(np.float32).astype(np.float64)).ids == tuple(sorted(IDS[:2]))


def test_two_copies_whose_points_carry_the_id_tell_both_ids(monkeypatch):
    def refused(_task, **_options):
        raise CapacityError("no cells")

    monkeypatch.setattr(embedding, "embed_in_cells", refused)
    made = [embedding.embed(Mesh(POINTS, FACES), KEY, id=each) for each in IDS[:2]]
    assert [each.mark.at_points for each in made] == [True, True]
    positions = np.array([each.mesh.vertices for each in made])
    together = [told(TOGETHER[name](positions)).ids for name in TOGETHER]
    assert together == [tuple(sorted(IDS[:2]))] * len(TOGETHER)
    assert extract(made[0].mesh, KEY).id == IDS[0]


def test_a_sum_that_shows_an_id_of_nobody_names_nobody():
    """Its coordinates show the sum of three words, which is a word; witnesses are no code."""
    one, two, three = copies(3)
    suspect = one + two - three
    found = told(suspect)
    assert Codec(KEY).decode(found.reading.observed()).id not in (None, *IDS)
    assert (found.ids, found.combined, found.present) == ((), True, True)
    answer = extract(Mesh(suspect, FACES), KEY)
    assert (answer.presence, answer.ids) == ("present", ())
    assert "none of them has" in answer.advice


def test_of_three_averaged_copies_those_that_are_listed_are_named_and_no_other():
    listed = (5, *IDS, 13)
    found = told(TOGETHER["average"](copies(3)), among=listed)
    assert found.ids == tuple(sorted(IDS))


@pytest.mark.parametrize("name", TOGETHER)
def test_of_three_copies_put_together_those_that_are_listed_are_named_and_no_other(name):
    listed = (*range(100, 1000), *IDS)
    found = told(TOGETHER[name](copies(3)), among=listed)
    assert found.ids == tuple(sorted(IDS))
    assert max(found.log10_words) < -6.0


def test_a_frame_that_is_turned_by_milliradians_is_found():
    """A small piece was put beside the model: no point of the copy moved, but its frame did."""
    vertices = marked(ID).mesh.vertices
    piece = 0.45 * POINTS[FACES[::600].ravel()] + [1.0, 1.5, 0.6]
    added = len(vertices) + np.arange(len(piece)).reshape(-1, 3)
    surface = surface_of(Mesh(np.vstack([vertices, piece]), np.vstack([FACES, added])))
    turned = surface.frame.axes @ surface_of(Mesh(vertices, FACES)).frame.axes.T
    assert 1.5e-3 < np.abs(turned - np.eye(3)).max() < 5e-3
    label = Label.of_shape(surface_of(Mesh(POINTS, FACES)).invariants, KEY)
    assert copies_of(Search(surface=surface, key=KEY, label=label)).ids == (ID,)
    assert copies_of(Search(surface=surface, key=OTHER, label=label)) is None


def test_authentication_says_that_copies_were_put_together():
    one, two, three = copies(3)
    averaged, summed = (
        authenticate(Mesh(each, FACES), KEY) for each in ((one + two) / 2.0, one + two - three)
    )
    assert (averaged.verdict, averaged.id) == (summed.verdict, summed.id) == ("inconclusive", None)
    assert "the ids of 2 copies, which were put together" in averaged.advice
    assert "its id cannot be read" in summed.advice
    assert max(averaged.log10_false_positive, summed.log10_false_positive) < -9.0
    assert (averaged.altered.sum(), summed.altered.sum()) == (0, 0)


@pytest.mark.parametrize("options", [{"key": OTHER}, {}], ids=["another key", "unmarked"])
def test_nothing_is_told_without_a_mark_of_this_key(options):
    assert told(marked(ID).mesh.vertices if options else POINTS, **options) is None


def test_a_damaged_copy_is_no_combination():
    """A third of the points are moved by so much that they say nothing."""
    random = np.random.default_rng(3)
    vertices = marked(ID).mesh.vertices
    moved = random.random(len(vertices)) < 0.33
    noise = 1e-3 * random.normal(size=vertices.shape)
    found = find_copies(search_of(vertices + moved[:, None] * noise))
    assert (found.ids, found.combined) == ((ID,), False)


def test_where_time_is_out_nothing_is_told():
    assert told(TOGETHER["average"](copies(2)), trials=TrialCounter(1e-9)) is None


def test_all_copies_have_one_step_and_keep_the_budget():
    made = [marked(each) for each in IDS]
    assert len({(each.ownership.spacing, each.ownership.step) for each in made}) == 1
    assert all(
        each.displacement.rms <= BUDGETS["standard"] * each.displacement.diagonal
        and extract(each.mesh, KEY).id == identity
        for each, identity in zip(made, IDS, strict=True)
    )


def test_points_of_copies_go_to_the_same_places_where_their_bits_are_the_same():
    """The mean of two copies keeps what they have in common, though the cells moved them apart."""
    codec = Codec(KEY)
    found = told(TOGETHER["average"](copies(2)))
    keys, words = found.reading.keys, [codec.encode(each) for each in IDS[:2]]
    one, other = (word[keys.code_index] for word in words)
    data = ~keys.pilot
    cosine = np.cos(found.reading.phase - np.pi * one)
    assert cosine[data & (one == other)].mean() > 0.4
    assert np.cos(found.reading.phase[keys.pilot]).mean() > 0.4
    assert abs(cosine[data & (one != other)].mean()) < 0.1
