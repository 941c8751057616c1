"""The page of a report: the policy that locks it, what it says, and what becomes of hostile names."""

from __future__ import annotations

import base64
import hashlib
import re
from datetime import UTC, datetime
from types import SimpleNamespace

import pytest

from meshmark.authentication.regions.region import Region
from meshmark.report import report_page as pages
from meshmark.report.meaning import MEANINGS
from meshmark.report.provenance import Provenance, provenance
from meshmark.report.report_page import Report, Table, report_page
from tests.counting import some

MADE = datetime(2026, 11, 5, 8, 3, tzinfo=UTC)
ORIGIN = Provenance(name="<b>.ply", files=(("<b>.ply", "ab" * 32),), key="0123", reference="", made=MADE)
VIEW = {"label": "</script><script>alert(1)</script>"}


def report(answer: str = "altered", **more) -> Report:
    return Report(
        kind="Authentication",
        answer=answer,
        tone="bad",
        heading="Altered",
        lead="12 % of the surface, below 10^−12.",
        next="Use `meshmark recover`.",
        facts=[("Id", "none")],
        sure=["Because."],
        provenance=ORIGIN,
        **more,
    )


def sha(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


@pytest.fixture
def viewer(monkeypatch):
    monkeypatch.setattr(pages, "view_script", lambda: SimpleNamespace(script="export {};", style=".v{}"))


def test_the_policy_allows_what_is_in_the_page_and_nothing_else(viewer):
    page = report_page(report(view=VIEW))
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]+)"', page)
    policy = policy.replace("&#39;", "'")
    (style,) = re.findall(r"<style>(.*?)</style>", page, re.DOTALL)
    (script,) = re.findall(r'<script type="module">(.*?)</script>', page, re.DOTALL)
    assert policy == (
        f"default-src 'none'; img-src data:; style-src '{sha(style)}'; script-src '{sha(script)}'; "
        "base-uri 'none'; form-action 'none'"
    )
    assert not re.search(r"""style=["']""", page), "the policy forbids styles of single elements"
    assert script == "export {};"
    assert page.count("</script>") == 2, "nothing in a view ends its script"


def test_without_the_viewer_the_page_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(pages, "view_script", lambda: None)
    page = report_page(report(view=VIEW))
    assert "<script" not in page
    assert "script-src &#39;none&#39;" in page
    assert "<code>pip install meshmark[web]</code>" in page
    assert "alert(1)" not in page


def test_it_names_its_file_its_key_and_its_date_and_escapes_them(viewer):
    page = report_page(report())
    assert "<b>" not in page
    assert "&lt;b&gt;.ply" in page
    assert "5 November 2026, 08:03 UTC" in page
    assert "ab" * 32 in page
    assert "12&nbsp;% of the surface, below 10<sup>−12</sup>." in page
    assert "Use <code>meshmark recover</code>." in page
    assert "data-view" not in page


def test_regions_and_tables_are_shown(viewer):
    region = Region(
        id=7, verdict="altered", probability=0.975, checks=1785, failed=12, log10_chance=-3.0, centre=(0, 0, 0),
        where="top",
    )  # fmt: skip
    unchecked = Region(
        id=8, verdict="unchecked", probability=0.0, checks=0, failed=0, log10_chance=0.0, centre=(0, 0, 0)
    )
    table = Table(title="Evidence", columns=("What", "Share"), rows=(("cells", "40 %"),))
    page = report_page(report(regions=[region, unchecked], tables=[table]))
    assert "<td>0.7 %</td>" in page
    assert "<td>–</td>" in page
    assert "<td>40&nbsp;%</td>" in page


@pytest.mark.parametrize("answer", MEANINGS)
def test_every_answer_says_what_it_means_and_what_its_limits_are(viewer, answer):
    page = report_page(report(answer))
    for sentence in some((*MEANINGS[answer].means, *MEANINGS[answer].not_means), least=2):
        assert sentence.endswith(".")
    assert page.count("<li>") == len(MEANINGS[answer].means) + len(MEANINGS[answer].not_means)


def test_the_sum_is_that_of_the_file_and_standard_input_has_none(tmp_path):
    model = tmp_path / "a.ply"
    model.write_bytes(b"ply")
    rows = dict(provenance("a.ply", {"a.ply": model}, "0123", made=MADE).rows())
    assert rows["SHA-256"] == hashlib.sha256(b"ply").hexdigest()
    rows = dict(provenance("standard input", {"-": tmp_path / "-"}, "0123").rows())
    assert rows["SHA-256"].startswith("none")
