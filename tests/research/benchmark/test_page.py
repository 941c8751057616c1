from __future__ import annotations

import re
from dataclasses import replace

import pytest
from lxml import etree

from meshmark.research.benchmark.figures.aggregate import robustness
from meshmark.research.benchmark.figures.labels import label
from meshmark.research.benchmark.page.page import page
from meshmark.research.benchmark.page.plots import plots
from meshmark.research.benchmark.page.report_parts import Cell, Section, Table
from meshmark.research.benchmark.sections import sections
from tests.counting import some
from tests.research.benchmark.browser import CHROMIUM, look
from tests.research.benchmark.planted import REFUSED, planted_facts, planted_rows

FACTS = planted_facts()


def whole(rows, facts=FACTS) -> str:
    return page("meshmark bench robust", sections(rows, facts, plots(rows)), facts)


@pytest.fixture(scope="module")
def report() -> str:
    return whole(planted_rows(("ncdg_lv", "<b>lsb</b>"), models=18, budgets=("standard",)))


def tree(text: str) -> etree._Element:
    """Return the page as a tree; the parser is strict about tags that HTML knows."""
    parser = etree.HTMLParser(recover=False)
    # libxml2 knows HTML 4; these came later and are checked by their closing tags alone.
    known = re.sub(r"<(/?)(main|nav|header|section|figure|figcaption|details|summary)\b", r"<\1div", text)
    without = re.sub(r"<svg.*?</svg>", "", known, flags=re.DOTALL)
    return etree.fromstring(without, parser)


def test_the_page_is_well_formed(report):
    root = tree(report)
    assert len(root.findall(".//table")) > 10
    for svg in re.findall(r"<svg.*?</svg>", report, flags=re.DOTALL):
        etree.fromstring(svg)


def test_identifiers_are_unique_and_links_lead_somewhere(report):
    names = re.findall(r'\sid="([^"]+)"', report)
    assert len(names) == len(set(names))
    targets = re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', report)
    assert {a or b for a, b in targets} <= set(names)


def test_the_page_asks_the_network_for_nothing(report):
    assert not re.search(r'(?:src|href)="(?!#|data:,)', report)
    assert not re.search(r"@import|<script|<iframe|<object|url\((?!#)", report)


def test_plots_and_tables_can_be_read_by_a_screen_reader(report):
    panels = re.findall(r'<svg class="panel"[^>]*>', report)
    assert panels
    assert all('role="img"' in panel and re.search('aria-label="[^"]{20,}"', panel) for panel in some(panels))
    root = tree(report)
    assert all(th.get("scope") in ("col", "row") for th in some(root.iter("th")))
    for table in some(root.iter("table")):
        widths = {len(tr) for tr in table.iter("tr")}
        assert len(widths) == 1


def test_every_table_and_plot_names_its_command(report):
    blocks = report.count('<div class="block">') + report.count("<details>")  # a group of them has a class
    assert report.count('<p class="made">') == blocks
    assert report.count(FACTS.command) >= blocks


def test_the_page_tells_what_was_measured():
    rows = planted_rows(models=12)
    text = page("meshmark bench robust", sections(rows, FACTS, {}), FACTS)
    assert REFUSED in text
    assert "Some processor" in text
    for attack in some({row.case.attack for row in rows}):
        assert f'<th scope="row">{label(attack)}</th>' in text
    wanted = ("test", "all", "noise:0.005")
    for figure in some(
        figure for figure in robustness(rows) if (figure.split, figure.size_class, figure.attack) == wanted
    ):
        value = f"{100 * figure.recovered.value:.1f}".rstrip("0").rstrip(".")
        assert f">{value} %<small>{100 * figure.recovered.low:.0f}–" in text


HOSTILE = '<script>alert("x")</script>&\'"><img src=x onerror=alert(1)>'


def test_nothing_from_outside_is_taken_for_markup():
    rows = [
        replace(
            row,
            case=replace(row.case, model=f"test/{HOSTILE}{row.case.model}", scheme=HOSTILE),
            note=HOSTILE if row.status != "ok" else "",
        )
        for row in planted_rows(models=6, budgets=("standard",))
    ]
    facts = replace(FACTS, suite=HOSTILE, command=HOSTILE, schemes={HOSTILE: HOSTILE}, processor=HOSTILE)
    text = page(HOSTILE, sections(rows, facts, plots(rows)), facts)
    assert not re.search(r"<script|<img", text)
    for svg in re.findall(r"<svg.*?</svg>", text, flags=re.DOTALL):
        etree.fromstring(svg)
    tree(text)


@pytest.mark.parametrize("kind", ["none", "refused", "failed", "one", "unmarked"])
def test_there_is_a_page_for_any_rows(kind):
    rows = planted_rows(models=5, budgets=("standard",))
    chosen = {
        "none": [],
        "refused": [row for row in rows if row.status == "refused"],
        "failed": [replace(row, status="failed", note="it broke", points=None, size_class=None, ber=None,
                           present=None, recovered=None, split="") for row in rows],
        "one": rows[-1:],
        "unmarked": [row for row in rows if row.case.trial == "unmarked"],
    }[kind]  # fmt: skip
    text = whole(chosen)
    tree(text)
    assert ("No case has been measured yet." in text) == (kind == "none")
    assert "nan" not in re.sub(r"<style.*?</style>|<svg.*?</svg>", "", text, flags=re.DOTALL).lower()


def test_cells_are_coloured_by_their_rate():
    table = Table(
        title="t",
        columns=("name", "rate"),
        rows=((Cell(text="a"), Cell(text="25 %", small="n = 4", heat=0.25)),),
    )
    text = page("t", [Section(name="s", title="S", words=(), parts=(table,))], FACTS)
    assert '<td class="heat" style="--good:25%">25 %<small>n = 4</small></td>' in text


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
@pytest.mark.parametrize("width", [1280, 400])
def test_a_browser_shows_the_page_without_errors_and_without_scrolling_sideways(report, tmp_path, width):
    seen = look(report, tmp_path, width)
    assert seen.width == width
    assert (seen.errors, seen.console, seen.fetched) == ([], "", [])
    assert seen.scroll <= width
    assert seen.out == []
    assert seen.narrowest >= 300, "panels keep a readable size"
    assert seen.text > 5000


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_the_watch_of_the_browser_sees_what_is_wrong(tmp_path):
    bad = "<html><head></head><body><main><div style='width:900px'>x</div></main><script>nonsense()</script>"
    seen = look(bad + "<img src='missing.png'></body></html>", tmp_path, 400)
    assert any("nonsense" in error for error in seen.errors)
    assert any("missing.png" in error for error in seen.errors)
    assert seen.scroll > 400
    assert len(seen.out) == 1
