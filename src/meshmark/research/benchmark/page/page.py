"""A report as one HTML page that needs nothing else: pictures and styles are inside, nothing comes by network."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from itertools import groupby
from typing import TYPE_CHECKING

from meshmark.report.html import html_page, trusted
from meshmark.research.benchmark.page.drawing import COLOURS
from meshmark.research.benchmark.page.report_parts import Panel, Plot, Section, Table
from meshmark.research.benchmark.run.facts import Facts

if TYPE_CHECKING:
    from markupsafe import Markup

__all__ = ["page"]

_LONG = 30  # letters in one line
_MANY = 6  # folded parts that stand openly in a row
_DASHES = ("", "6 3", "2 2")


def page(title: str, sections: Sequence[Section], facts: Facts) -> str:
    """Return the page; every text in it is escaped."""
    return html_page(
        "benchmark.html",
        "research/benchmark/page",
        title=title,
        origin=_origin(facts),
        command=facts.command,
        sections=sections,
        many=_MANY,
        colours=COLOURS,
        dashes=_DASHES,
        runs=_runs,
        column_kinds=_column_kinds,
        labelled_svg=_labelled_svg,
    )


def _origin(facts: Facts) -> str:
    parts = [facts.started.replace("T", " ").removesuffix("+00:00") + " UTC" if facts.started else ""]
    parts += [f"meshmark {facts.versions['meshmark']}" if "meshmark" in facts.versions else ""]
    parts += [facts.processor, f"seed {facts.seed}"]
    return " · ".join(part for part in parts if part)


def _runs(parts: Sequence[Table | Plot]) -> list[list[Table | Plot]]:
    """Return the parts in runs of folded and of open ones."""
    return [list(run) for _, run in groupby(parts, key=lambda part: part.folded)]


def _column_kinds(table: Table) -> list[str]:
    """Return the class of each column: words stand left, long ones in several lines; figures, "", stand right."""
    return [_kind([row[i].text for row in table.rows]) for i in range(len(table.columns))]


def _kind(texts: Sequence[str]) -> str:
    if all(text[:1].isdigit() or text[:1] in "–−∞" for text in texts):
        return ""
    return "text" if max(map(len, texts)) > _LONG else "word"


def _labelled_svg(panel: Panel) -> Markup:
    """Return the picture, drawn by us and escaped there, with what it shows in words."""
    label = f'<svg class="panel" aria-label="{escape(panel.alt)}" '
    return trusted(panel.svg.replace("<svg ", label, 1))
