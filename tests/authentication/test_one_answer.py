"""One answer from what layers and parts say, with one bound."""

from __future__ import annotations

import pytest

from meshmark.authentication.one_answer import one_answer
from meshmark.coding.message import format_id
from meshmark.ownership.extraction_result import Evidence, Extraction
from tests.keys import ID, IDENTITY, KEY, OTHER, OTHER_ID
from tests.marked import marked_pebble


def said(layer: str, identity: int | None, bound: float = -40.0, share: float = 1.0) -> Evidence:
    return Evidence(layer=layer, id=identity, log10_false_positive=bound, share=share)


def read(*evidence: Evidence, presence: str = "present") -> Extraction:
    """Return what the ownership layer answers with this evidence."""
    ids = tuple(each.id for each in evidence if each.id is not None)
    return Extraction(
        presence=presence,
        id=ids[0] if len(ids) == 1 else None,
        ids=ids,
        log10_false_positive=evidence[0].log10_false_positive if evidence else 0.0,
        mode="blind",
        carriers=1,
        carriers_agreeing=1,
        lock_score=1.0,
        advice="As it was.",
        seconds=1.0,
        evidence=evidence,
    )


def test_layers_that_agree_are_as_sure_as_the_surer_one():
    found = one_answer(read(said("cells", ID, -8.0)), [said("authentication", ID, -60.0, 0.9)], key=KEY)
    assert (found.presence, found.id, found.ids, found.advice) == ("present", ID, (ID,), "As it was.")
    assert [entry.layer for entry in found.evidence] == ["authentication", "cells"]
    assert -60.0 < found.log10_false_positive == found.evidence[0].log10_false_positive < -58.0
    assert -8.0 < found.evidence[1].log10_false_positive < -7.9


def test_marks_alone_give_the_id():
    found = one_answer(read(presence="absent"), [said("authentication", ID)], key=KEY)
    assert (found.presence, found.id) == ("present", ID)
    assert found.advice.startswith(
        "The id was read from the authentication marks; the ownership mark was not found."
    )
    beside = one_answer(read(said("cells", None)), [said("authentication", ID)], key=KEY)
    assert "the ownership mark is too damaged to read" in beside.advice
    assert len(beside.evidence) == 2


def test_layers_that_disagree_give_both_ids_and_are_as_sure_as_the_less_sure_one():
    found = one_answer(read(said("cells", ID, -9.0)), [said("authentication", OTHER_ID, -60.0, 0.9)], key=KEY)
    assert (found.presence, found.id, found.ids) == ("present", None, (ID, OTHER_ID))
    assert -9.0 < found.log10_false_positive < -8.9
    assert f"{IDENTITY} (cells, 100 %) and {format_id(OTHER_ID)} (authentication, 90 %)" in found.advice


def test_ids_of_parts_come_with_the_largest_share_first():
    marks = [said("authentication", ID, share=0.2), said("authentication", OTHER_ID, share=0.5)]
    found = one_answer(read(presence="absent"), marks, [said("cells", ID, share=0.3)], key=KEY)
    assert found.ids == (OTHER_ID, ID)
    assert f"{IDENTITY} (authentication and cells, 30 %)" in found.advice


def test_an_average_stays_what_it_is():
    found = one_answer(read(said("cells", OTHER_ID), said("cells", ID)), [], key=KEY)
    assert (found.id, found.ids, found.advice) == (None, (OTHER_ID, ID), "As it was.")


def test_no_evidence_changes_nothing():
    nothing = read(presence="absent")
    assert one_answer(nothing, [], key=KEY) is nothing


@pytest.mark.parametrize("identity", [ID, None])
def test_what_is_not_sure_enough_for_all_that_was_looked_at_is_no_answer(identity):
    found = one_answer(read(said("cells", identity, -6.01)), [], key=KEY)
    assert (found.presence, found.id, found.ids, found.evidence) == ("inconclusive", None, (), ())
    part = one_answer(read(presence="absent"), [], [said("cells", ID, -7.2)], key=KEY)
    assert (part.presence, part.ids) == ("absent", ())


def test_the_certificate_of_another_mark_is_told_of_where_no_id_is_its_own():
    certificate = marked_pebble().certificate
    absent = read(presence="absent")
    other = one_answer(absent, [said("authentication", OTHER_ID)], key=KEY, reference=certificate)
    assert "The certificate is that of another mark" in other.advice
    both = [said("authentication", OTHER_ID, share=0.5), said("authentication", ID, share=0.4)]
    assert "certificate" not in one_answer(absent, both, key=KEY, reference=certificate).advice
    assert "made with another key" in one_answer(absent, both, key=OTHER, reference=certificate).advice
