"""Where a search ends: at the first id, or, where one is to be sure, at the first that is."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from meshmark.coding.message import PRESENCE
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership import extraction
from meshmark.ownership.decoding import Found
from meshmark.ownership.extraction import find
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.strategies import Strategy
from tests.keys import KEY

LISTED = (5, 6)
WORDS = (-3.0, -5.0, -4.0, -8.0, -20.0)


@pytest.fixture
def search(monkeypatch: pytest.MonkeyPatch) -> Search:
    """A search with five readings, whose words are the less likely by chance the later they come, but for one."""
    readings = list(range(len(WORDS)))
    made = Strategy(name="planted", readings=lambda _: iter(readings), applies=lambda _: True, cost=1.0)
    monkeypatch.setattr(extraction, "STRATEGIES", (made,))
    monkeypatch.setattr(extraction, "_better", lambda one, other: other if one is None else one)

    def decoded(_codec, reading, _listed, _charged):
        found = Found(reading=None, present=True, log10_false_positive=-9.0, ids=(reading,))
        return replace(found, log10_words=(WORDS[reading],))

    monkeypatch.setattr(extraction, "decoded", decoded)
    return Search(surface=surface_of(Mesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 1, 3]]))), key=KEY)


@pytest.mark.parametrize(
    ("sure", "expected"), [(None, 0), (-2.0, 0), (-4.5, 1), (-6.0, 3), (-10.0, 4), (-30.0, 4)]
)
def test_a_search_ends_with_the_first_id_that_is_sure_enough_or_the_surest(search, sure, expected):
    assert find(replace(search, sure=sure)).ids == (expected,)
    assert search.trials.charge_decoding() == 2 * (expected + 2) * (expected + 3), "it did not go on"


def told(ids: tuple[int, ...], words: tuple[float, ...]) -> Found:
    """Return what was found of which `LISTED` ids were looked for, with these chances of the words."""
    reading: Any = SimpleNamespace(log10_chance=-20.0, hypotheses=10.0)
    found = Found(reading=reading, present=True, log10_false_positive=-30.0, ids=ids, log10_words=words)
    return extraction._surely_named(found, LISTED)


@pytest.mark.parametrize(
    ("ids", "words", "kept"),
    [
        ((5,), (-6.5,), (5,)),
        ((8,), (-5.5,), (8,)),  # was looked for among all
        ((5, 6), (-9.0, -5.5), (5,)),
        ((5, 8), (-5.0, -5.5), (8,)),
        ((PRESENCE,), (), (PRESENCE,)),
    ],
)
def test_listed_ids_are_named_only_where_another_copy_hardly_tells_them(ids, words, kept):
    named = told(ids, words)
    assert named.ids == kept
    assert len(named.log10_words) == len(set(kept) - {PRESENCE})
    assert named.log10_false_positive == -30.0


def test_where_no_id_is_sure_the_mark_is_still_there_by_its_lock():
    named = told((5,), (-5.5,))
    assert (named.ids, named.log10_words) == ((), ())
    assert named.present
    assert -20.0 < named.log10_false_positive < -15.0


def test_strategies_are_chosen(search):
    assert find(search, lambda strategy: strategy.name == "planted").ids == (0,)
    nothing = find(replace(search), lambda _: False)
    assert (nothing.ids, nothing.present) == ((), False)
