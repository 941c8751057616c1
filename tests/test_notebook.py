"""Results in notebooks: a heading and a table, escaped, without keys."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np

import meshmark as mm
from meshmark.notebook import notebook_table
from tests.counting import some
from tests.keys import IDENTITY, KEY
from tests.marked import marked_pebble


def test_every_text_is_escaped_and_empty_rows_are_left_out():
    html = notebook_table("<b>", [("a", '1 < 2 & "3"'), ("empty", "")])
    root = ElementTree.fromstring(html)
    assert root.findtext("strong") == "<b>"
    assert [cell.text for cell in root.iter("td")] == ['1 < 2 & "3"']


def test_each_result_shows_what_it_says_and_no_key():
    made = marked_pebble()
    pushed = made.mesh.with_vertices(
        np.where(made.mesh.vertices[:, :1] > 0.9 * made.mesh.vertices[:, 0].max(), 1.1, 1.0)
        * made.mesh.vertices
    )
    found, check = mm.extract(made.mesh, KEY), mm.authenticate(pushed, KEY)
    whole = mm.recover(pushed, KEY)
    absent = replace(found, presence="absent", ids=())
    shown = {
        "Marked": made,
        "Present": found,
        "Absent": absent,
        "Altered": check,
        "Recovered" if whole.mesh is not None else "Not recovered": whole,
    }
    for heading, result in some(shown.items(), least=5):
        html = result._repr_html_()
        assert len(html) < 3000
        assert ElementTree.fromstring(html).findtext("strong") == heading
        assert KEY.fingerprint not in html
    assert IDENTITY in made._repr_html_()
    assert IDENTITY in found._repr_html_()
    assert check.advice in ElementTree.fromstring(check._repr_html_()).findtext(".//td")
