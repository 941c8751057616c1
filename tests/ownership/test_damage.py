"""Marks are read after damage: blind where the shape can be restored, by a reference where part of it is gone."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.coding.keys import Key
from meshmark.marking import embed, extract
from meshmark.mesh import Mesh
from meshmark.ownership import extraction
from meshmark.ownership.search import search
from tests.keys import ID, KEY
from tests.shapes import boulder, pebble


@pytest.fixture(autouse=True)
def fine(monkeypatch):
    """Let all models pass for fine ones: smoothing is taken back exactly in test_unsmoothed.py."""
    monkeypatch.setattr(search, "COARSE", 0)


@pytest.fixture(scope="module")
def model() -> Mesh:
    return Mesh(*pebble(144))


@pytest.fixture(scope="module")
def marked(model):
    return embed(model, KEY, id=ID, layers="ownership")


def attacked(mesh, text):
    return parse_chain(text)(mesh, np.random.default_rng(7))


@pytest.mark.parametrize(
    "text",
    [
        "noise:0.005+similarity:1",
        "smoothing:30",
        "smoothing_half:10",
        "quantisation:8",
        "simplification:0.7",
    ],
)
def test_blind_reading_survives(marked, text):
    found = extract(attacked(marked.mesh, text), KEY)
    assert (found.presence, found.id, found.mode) == ("present", ID, "blind")
    assert found.log10_false_positive <= -6.0


@pytest.mark.parametrize("text", ["crop:0.05+similarity:1", "crop:0.1+noise:0.003+similarity:1", "crop:0.4"])
def test_the_certificate_finds_the_mark_where_blind_reading_fails(marked, text, short_search):
    suspect = attacked(marked.mesh, text)
    assert extract(suspect, KEY, search="plain").id is None
    found = extract(suspect, KEY, reference=marked.certificate)
    assert (found.presence, found.id, found.mode) == ("present", ID, "certificate")
    assert found.log10_false_positive <= -6.0


def test_a_small_stretch_is_undone_where_a_rough_surface_hides_large_steps(monkeypatch):
    marked = embed(Mesh(*boulder(70)), KEY, id=ID, layers="ownership")
    suspect = attacked(marked.mesh, "affine:0.01")
    assert extract(suspect, KEY, search="plain").id is None
    ways = tuple(way for way in extraction.STRATEGIES if way.name in ("registered", "stretched"))
    monkeypatch.setattr(extraction, "STRATEGIES", ways)  # the others take time, and do not read it
    found = extract(suspect, KEY, reference=marked.certificate)
    assert (found.presence, found.id, found.mode) == ("present", ID, "certificate")


def test_so_does_the_original(model, marked, short_search):
    found = extract(attacked(marked.mesh, "crop:0.3+similarity:1"), KEY, reference=model)
    assert (found.presence, found.id, found.mode) == ("present", ID, "original")


def test_a_reference_makes_no_mark(model, marked, short_search):
    """The unmarked model fits the certificate as well as the marked one, and another key finds nothing."""
    assert extract(model, KEY, reference=marked.certificate).presence == "absent"
    assert extract(marked.mesh, Key(bytes(32)), reference=marked.certificate).presence == "absent"


def test_what_is_read_is_the_same_every_time(marked):
    suspect = attacked(marked.mesh, "smoothing:10")
    first, second = (extract(suspect, KEY) for _ in range(2))
    assert first.lock_score == second.lock_score
    assert first.log10_false_positive == second.log10_false_positive
