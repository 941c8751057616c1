"""Whose copy a suspect is: damaged copies, averages, and who is never named."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import meshmark as mm
from meshmark.attacks import ATTACKS
from meshmark.errors import InputError
from meshmark.ownership.decoding import Found
from meshmark.ownership.parameters import ACCUSED_LOG10
from meshmark.registry import tracing
from meshmark.registry.entering import original_of_mesh
from meshmark.registry.recording import mark_of
from meshmark.registry.registry import Registry
from meshmark.registry.tracing import trace
from tests.keys import KEY, OTHER
from tests.registry.records_samples import copy
from tests.shapes import pebble

ACROSS, COPIES = 40, 2


@pytest.fixture(scope="module")
def issued(tmp_path_factory):
    """A registry of two copies of a pebble, and of a hundred of another shape; the copies."""
    registry, _ = Registry.create(tmp_path_factory.mktemp("registry") / "issued.db")
    points, faces = pebble(ACROSS)
    mesh = mm.Mesh(points, faces)
    original = original_of_mesh(mesh, "pebble.ply", registry)
    marked = []
    for number in range(COPIES):
        made = mm.embed(mesh, KEY, id=number + 1, layers="ownership", strength="strong")
        enter(registry, original, made.certificate, number + 1, f"recipient {number + 1}")
        marked.append(made.mesh)
    other = original_of_mesh(mm.Mesh(points * [1.0, 0.5, 2.0], faces), "other.ply", registry)
    for number in range(100):
        registry.reserve(other, KEY.fingerprint, recipient=f"innocent {number}")
    with registry:
        yield registry, marked


def enter(registry, original, certificate, id, recipient):
    registry.reserve(original, KEY.fingerprint, id=id, recipient=recipient)
    made = replace(
        copy(id, recipient), key=KEY.fingerprint, original=original.digest, mark=mark_of(certificate)
    )
    registry.complete(made, json.dumps(certificate.to_dict()))
    registry.confirm(id, KEY.fingerprint)


def names(found):
    assert (
        max((each.log10_false_accusation for each in found.matches), default=ACCUSED_LOG10) <= ACCUSED_LOG10
    )
    return [each.recipient for each in found.matches]


def test_a_copy_as_it_was_issued_names_its_recipient(issued):
    registry, marked = issued
    found = trace(marked[1], KEY, registry)
    (match,) = found.matches
    assert (match.recipient, match.id, match.original, match.method) == (
        "recipient 2",
        2,
        "pebble.ply",
        "blind",
    )
    assert (found.extraction.mode, found.extraction.id) == ("registry", 2)
    assert [each.name for each in found.candidates] == ["pebble.ply", "other.ply"]
    assert found.to_dict()["matches"] == [match.to_dict()]


def test_a_part_names_its_recipient_by_the_certificate_of_the_registry(issued):
    """The certificate of the first copy serves for the second, too."""
    registry, marked = issued
    rng = np.random.default_rng(1)
    part = ATTACKS["similarity"](ATTACKS["crop"](marked[1], 0.15, rng), 1, rng)
    assert mm.extract(part, KEY, search="plain").id is None
    found = trace(part, KEY, registry, search="plain")
    assert names(found) == ["recipient 2"]
    assert found.matches[0].method == "registered"


def test_of_several_ids_those_are_named_that_no_innocent_one_would_be_taken_for(issued, monkeypatch):
    registry, marked = issued

    def find(*_):
        found = Found(reading=None, present=True, log10_false_positive=-20.0, ids=(1, 2))
        return replace(found, log10_words=(ACCUSED_LOG10 - 0.1, ACCUSED_LOG10 + 0.1))

    monkeypatch.setattr(tracing, "find_copies", find)
    found = trace(marked[0], KEY, registry)
    assert names(found) == ["recipient 1"]
    assert found.extraction.ids == (1, 2)


def test_authentication_marks_name_a_recipient_where_nothing_else_is_left(issued, monkeypatch):
    registry, _ = issued

    def with_marks(found, *_):
        return replace(found, presence="present", id=2, ids=(2,), log10_false_positive=-50.0)

    monkeypatch.setattr(tracing, "with_marks", with_marks)
    found = trace(mm.Mesh(*pebble(ACROSS)), KEY, registry, search="plain")
    (match,) = found.matches
    assert (match.recipient, match.method, match.log10_false_accusation) == (
        "recipient 2",
        "authentication",
        -50.0,
    )


def test_nobody_is_named_by_what_is_not_marked_or_marked_with_another_key(issued):
    registry, marked = issued
    unmarked = mm.Mesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 1, 3]]))
    for mesh, key in ((unmarked, KEY), (marked[0], OTHER)):
        found = trace(mesh, key, registry, search="plain")
        assert found.matches == ()
        assert found.extraction.presence in ("absent", "inconclusive")


def test_an_id_without_a_row_names_nobody(issued, tmp_path):
    _, marked = issued
    with Registry.create(tmp_path / "empty.db")[0] as empty:
        found = trace(marked[0], KEY, empty)
    assert (found.extraction.id, found.matches) == (1, ())
    assert "The registry has no copy with this id." in found.extraction.advice


def test_a_certificate_that_was_edited_in_the_registry_is_refused(issued, tmp_path):
    registry, marked = issued
    edited = json.loads(registry.certificate(1, KEY.fingerprint))
    edited["spacing"] *= 1.01
    part = ATTACKS["crop"](marked[0], 0.15, np.random.default_rng(1))
    with Registry.create(tmp_path / "r.db")[0] as other:
        original = other.original("0" * 64) or registry.originals()[0]
        other.reserve(original, KEY.fingerprint, id=1)
        made = replace(copy(1), key=KEY.fingerprint, original=original.digest)
        other.complete(made, json.dumps(edited))
        with pytest.raises(InputError, match="the certificate was edited after it was made"):
            trace(part, KEY, other, search="plain")


@pytest.mark.parametrize(
    ("options", "message"),
    [({"search": "deep"}, "unknown search 'deep'"), ({"time_limit": 0.0}, "a time limit of 0 seconds")],
)
def test_arguments_that_cannot_be_used_are_refused(issued, options, message):
    registry, marked = issued
    with pytest.raises(InputError, match=message):
        trace(marked[0], KEY, registry, **options)
