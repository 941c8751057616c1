from __future__ import annotations

import pytest

from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.marking import extract
from meshmark.mesh import Mesh
from meshmark.ownership.search import trials
from tests.shapes import pebble

KEY = Key(bytes(32))


@pytest.fixture(scope="module")
def model() -> Mesh:
    return Mesh(*pebble(30))


def test_a_search_without_a_limit_ends_with_absent(model, short_search):
    assert extract(model, KEY).presence == "absent"


def test_a_limit_that_is_reached_leaves_the_question_open(model, monkeypatch):
    clock = iter(range(10**6))
    monkeypatch.setattr(trials, "monotonic", lambda: next(clock))
    found = extract(model, KEY, time_limit=3.0)
    assert (found.presence, found.id) == ("inconclusive", None)
    assert "time limit" in found.advice


def test_a_limit_before_the_first_reading_says_so_too(model, monkeypatch):
    clock = iter((0.0, 5.0))
    monkeypatch.setattr(trials, "monotonic", lambda: next(clock))
    found = extract(model, KEY, time_limit=1.0)
    assert (found.presence, found.carriers) == ("inconclusive", 0)
    assert "time limit" in found.advice


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan")])
def test_a_limit_must_be_above_0(model, seconds):
    with pytest.raises(InputError, match="time limit"):
        extract(model, KEY, time_limit=seconds)
