"""Extraction from both layers: what is asked, how far, and what is answered of parts."""

from __future__ import annotations

import numpy as np
import pytest

import meshmark as mm
from meshmark.attacks import parse_chain
from meshmark.errors import InputError
from meshmark.marking import both_layers_extraction as module
from meshmark.marking import embed, extract
from meshmark.mesh import Mesh
from tests.keys import ID, KEY, OTHER_ID
from tests.marked import marked_pebble, mosaic_of_pebbles, other_copy
from tests.shapes import pebble


@pytest.fixture
def efforts(monkeypatch):
    """Return the list of searches that the ownership layer is asked for, each answered as it stands only."""
    asked = []
    own = module.extract_ownership

    def plain(*arguments, search="quick", **options):
        asked.append(search)
        return own(*arguments, search="plain", **options)

    monkeypatch.setattr(module, "extract_ownership", plain)
    return asked


def test_the_python_interface_asks_both_layers(efforts):
    found = mm.extract(marked_pebble().mesh, KEY, search="wide")
    assert (found.presence, found.id, found.mode, efforts) == ("present", ID, "blind", ["plain"])
    assert [(entry.layer, entry.id) for entry in found.evidence] == [("authentication", ID), ("cells", ID)]
    assert found.evidence[0].share > 0.95
    assert found.evidence[1].share == 1.0


def test_a_crop_is_read_by_its_marks_and_searched_no_further(efforts):
    attack = parse_chain("crop:0.3+similarity:1+float32:1")
    found = extract(attack(marked_pebble().mesh, np.random.default_rng(5)), KEY)
    assert (found.id, efforts) == (ID, ["plain"])
    assert [entry.layer for entry in found.evidence] == ["authentication"]


def test_without_marks_the_ownership_layer_is_searched_as_asked(efforts):
    found = extract(Mesh(*pebble(48)), KEY, search="wide")
    assert (found.presence, found.ids, found.evidence, efforts) == ("absent", (), (), ["wide"])


def test_marks_on_little_of_the_surface_leave_the_search_as_asked(efforts):
    part, around = other_copy(48).mesh, Mesh(*pebble(70))
    vertices = np.concatenate([around.vertices, 0.3 * part.vertices + [5.0, 0.0, 0.0]])
    scene = Mesh(vertices, np.concatenate([around.faces, part.faces + len(around.vertices)]))
    found = extract(scene, KEY)
    assert (found.ids, efforts[0]) == ((OTHER_ID,), "quick")


def test_a_mosaic_names_both_copies():
    found = extract(mosaic_of_pebbles(), KEY)
    assert (found.presence, found.id, set(found.ids)) == ("present", None, {ID, OTHER_ID})
    assert found.advice.startswith("Parts or layers carry different ids: ")
    assert 0.8 < sum(entry.share for entry in found.evidence if entry.layer == "authentication") <= 1.0


def test_a_part_that_was_marked_by_itself_is_read_in_its_assembly(efforts):
    """The part carries the id alone, so that no mark tells it but in its own frame."""
    part = embed(Mesh(*pebble(48)), KEY, id=ID, layers="ownership").mesh
    around = Mesh(*pebble(60))
    vertices = np.concatenate([part.vertices, 2.0 * around.vertices + [0.0, 9.0, 0.0]])
    scene = Mesh(vertices, np.concatenate([part.faces, around.faces + len(part.vertices)]))
    found = extract(scene, KEY)
    assert (found.presence, found.id) == ("present", ID)
    assert found.advice == "The id was read from a part of the model by itself."
    (entry,) = found.evidence
    assert entry.layer == "cells"
    assert 0.1 < entry.share < 0.3
    assert efforts == ["quick"]


def test_layers_with_different_ids_give_both():
    first = embed(Mesh(*pebble(48)), KEY, id=ID, layers="ownership").mesh
    second = embed(first, KEY, id=OTHER_ID, layers="authentication", payload="none").mesh
    found = extract(second, KEY)
    assert {(entry.layer, entry.id) for entry in found.evidence} == {
        ("cells", ID),
        ("authentication", OTHER_ID),
    }
    assert (found.id, set(found.ids)) == (None, {ID, OTHER_ID})


def test_a_time_limit_leaves_what_the_marks_tell():
    found = extract(marked_pebble().mesh, KEY, time_limit=1e-6)
    assert found.ids == (ID,)
    nothing = extract(Mesh(*pebble(48)), KEY, time_limit=1e-6)
    assert nothing.presence == "inconclusive"


def test_what_is_wrong_with_a_request_is_told_before_anything_is_read(monkeypatch):
    monkeypatch.setattr(module, "evidence_of_marks", None)
    with pytest.raises(InputError, match="unknown search 'deep'"):
        extract(marked_pebble().mesh, KEY, search="deep")
