"""The pages of an embedding, an extraction and a recovery say what came out, and hold no key."""

from __future__ import annotations

import base64
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

import meshmark as mm
from meshmark.mesh import Mesh
from meshmark.report.embedding_page import embedding_report
from meshmark.report.extraction_page import extraction_report
from meshmark.report.provenance import Provenance
from meshmark.report.recovery_page import recovery_report
from meshmark.report.report_page import Report, report_page
from tests.counting import some
from tests.keys import ID, IDENTITY, KEY, OTHER_ID
from tests.marked import marked_pebble
from tests.shapes import pebble

pytestmark = pytest.mark.usefixtures("drafts")
ORIGIN = Provenance(
    name="a.ply", files=(), key=KEY.fingerprint, reference="", made=datetime(2026, 1, 1, tzinfo=UTC)
)
SECRET = bytes(range(32))


def layers(report: Report) -> list[str]:
    assert report.view is not None
    names = [layer["name"] for layer in report.view["layers"]]
    assert report.view["start"] in names
    return names


def read(report: Report) -> str:
    """Return the page, which does not hold the key in any common form."""
    page = report_page(report)
    for form in some((SECRET.hex(), base64.b64encode(SECRET).decode(), SECRET.hex().upper())):
        assert form not in page
    return page


def test_an_embedding_shows_the_displacement_and_warns_of_it():
    report = embedding_report(Mesh(*pebble(58)), marked_pebble(), ORIGIN)
    page = read(report)
    assert layers(report) == ["surface", "displacement", "saliency"]
    assert f"The model carries the id {IDENTITY}" in page
    assert "not for strangers" in page
    largest = 100.0 * marked_pebble().max_over_diagonal
    (ticks,) = (
        layer["legend"]["ticks"] for layer in report.view["layers"] if layer["name"] == "displacement"
    )
    assert float(ticks[-1]["label"]) == pytest.approx(largest, rel=0.1)
    assert page.count("<figure>") == 3


def test_an_extraction_names_ids_recipients_and_evidence():
    found = mm.extract(marked_pebble().mesh, KEY)
    report = extraction_report(marked_pebble().mesh, found, ORIGIN, ["Ann <ann@example.org>"])
    page = read(report)
    assert layers(report) == ["surface", "saliency"]
    assert f"The model carries the id {IDENTITY}, issued to Ann &lt;ann@example.org&gt;." in page
    assert "<h1>A mark of this key is present</h1>" in page
    assert "authentication marks" in page
    assert "below 10<sup>−30</sup>" in page
    both = replace(found, ids=(ID, OTHER_ID), id=None)
    assert (
        f"the ids {IDENTITY}, {OTHER_ID:016x}." in extraction_report(marked_pebble().mesh, both, ORIGIN).lead
    )


@pytest.mark.parametrize(
    ("presence", "heading"), [("absent", "No mark of this key"), ("inconclusive", "Inconclusive")]
)
def test_an_extraction_without_a_mark_claims_nothing(presence, heading):
    found = replace(
        mm.extract(marked_pebble().mesh, KEY),
        presence=presence,
        id=None,
        ids=(),
        evidence=(),
        advice="Try more.",
    )
    report = extraction_report(marked_pebble().mesh, found, ORIGIN)
    page = read(report)
    assert f"<h1>{heading}</h1>" in page
    assert "10<sup>" not in page
    assert IDENTITY not in page
    assert report.tables == []


def test_a_recovery_says_what_was_restored_and_what_is_as_signed():
    mesh = marked_pebble().mesh
    end = mesh.vertices[:, 0] > np.quantile(mesh.vertices[:, 0], 0.93)
    suspect = mesh.with_vertices(np.where(end[:, None], 1.1 * mesh.vertices, mesh.vertices))
    found, made = mm.authenticate(suspect, KEY), mm.recover(suspect, KEY)
    assert made.mesh is not None
    report = recovery_report(suspect, found, made, ORIGIN)
    page = read(report)
    assert {"restored", "saliency", "surface"} <= set(layers(report))
    assert "<h1>Restored where it was altered</h1>" in page
    assert "is as it was signed off" in page
    assert "Regions before the recovery" in page
    assert "Restored from the miniature" in str(report.view)
    assert "The miniature is sealed into the marks" in page
    again = replace(made, restored_from="marked_copy", intact_rms_over_diagonal=7e-9, advice="Done.")
    report = recovery_report(suspect, found, again, ORIGIN)
    page = read(report)
    assert "lie 7e-07&nbsp;% of the diagonal (RMS)" in page
    assert "miniature" not in page
    other = recovery_report(suspect, found, replace(made, restored_from="original"), ORIGIN)
    assert (report.answer, other.answer) == ("recovered_copy", "recovered_original")
    whole = mm.recover(mesh, KEY)
    report = recovery_report(mesh, mm.authenticate(mesh, KEY), whole, ORIGIN)
    assert (report.heading, report.answer) == ("Nothing was altered", "authentic")
