"""What is read of a model whose marks do not hold."""

from __future__ import annotations

import pytest

from meshmark.authentication import examination
from meshmark.authentication.examination import examine
from tests.keys import ID, KEY
from tests.marked import marked_pebble


def test_the_ownership_layer_tells_the_id_of_a_model_without_marks():
    found = examine(marked_pebble(layers="ownership").mesh, KEY)
    assert (found.marked, found.id) == (False, ID)


def test_where_marks_were_just_made_and_do_not_hold_the_ownership_layer_is_not_read(monkeypatch):
    monkeypatch.setattr(examination, "extract", lambda *_, **__: pytest.fail("the ownership layer was read"))
    found = examine(marked_pebble(layers="ownership").mesh, KEY, made=ID)
    assert (found.marked, found.id, found.altered.all()) == (False, None, True)


def test_marks_that_were_just_made_are_read_as_any_are():
    mesh = marked_pebble().mesh
    made, found = examine(mesh, KEY, made=ID), examine(mesh, KEY)
    assert (made.marked, made.id, made.altered.any()) == (found.marked, found.id, found.altered.any())
    assert (made.marked, made.id, made.payload) == (True, ID, found.payload)
