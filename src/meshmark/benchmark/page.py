"""A report as one HTML page that needs nothing else: pictures and styles are inside, nothing comes by network."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from importlib import resources
from itertools import groupby

from meshmark.benchmark.drawing import COLOURS
from meshmark.benchmark.facts import Facts
from meshmark.benchmark.layout import Cell, Entry, Plot, Section, Table

__all__ = ["page"]

_LONG = 30  # letters in one line
_MANY = 6  # folded parts that stand openly in a row


def page(title: str, sections: Sequence[Section], facts: Facts) -> str:
    """Return the page; every text in it is escaped."""
    links = "".join(f'<a href="#{s.name}">{escape(s.title)}</a>' for s in sections)
    body = "".join(_section(section, facts.command) for section in sections)
    return (
        "<!DOCTYPE html>\n"
        '<html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f'<link rel="icon" href="data:,">\n<title>{escape(title)}</title>\n<style>\n{_style()}</style></head>\n'
        f"<body><header><h1>{escape(title)}</h1><p>{_origin(facts)}</p></header>\n"
        f'<nav aria-label="Parts of the report">{links}</nav>\n<main>{body}</main></body></html>\n'
    )


def _style() -> str:
    return resources.files("meshmark").joinpath("benchmark/page.css").read_text(encoding="utf-8")


def _origin(facts: Facts) -> str:
    parts = [facts.started.replace("T", " ").removesuffix("+00:00") + " UTC" if facts.started else ""]
    parts += [f"meshmark {facts.versions['meshmark']}" if "meshmark" in facts.versions else ""]
    parts += [facts.processor, f"seed {facts.seed}"]
    return escape(" · ".join(part for part in parts if part))


def _section(section: Section, command: str) -> str:
    kind = ' class="lead"' if section.name == "summary" else ""
    words = "".join(f"<p>{_prose(text)}</p>" for text in section.words)
    parts = ""
    for folded, run in groupby(section.parts, key=lambda part: part.folded):
        held = list(run)
        shown = "".join(_table(p, command) if isinstance(p, Table) else _plot(p, command) for p in held)
        parts += _group(held, shown) if folded and len(held) > _MANY else shown
    return f'\n<section id="{section.name}"{kind}><h2>{escape(section.title)}</h2>{words}{parts}</section>'


def _group(held: Sequence[Table | Plot], shown: str) -> str:
    words = f"{len(held)} more, from “{held[0].title}” to “{held[-1].title}”"
    return f'\n<details class="group"><summary>{escape(words)}</summary>{shown}</details>'


def _table(table: Table, command: str) -> str:
    kinds = [_kind([row[i].text for row in table.rows]) for i in range(len(table.columns))]
    head = "".join(
        f'<th scope="col"{k}>{escape(name)}</th>' for k, name in zip(kinds, table.columns, strict=True)
    )
    rows = "\n".join(_row(row, kinds) for row in table.rows)
    note = f"<p>{_prose(table.note)}</p>" if table.note else ""
    inside = (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(table.title)}"><table>'
        f"<thead><tr>{head}</tr></thead><tbody>\n{rows}</tbody></table></div>{note}{_made(command)}"
    )
    return _block(table.title, inside, table.folded)


def _kind(texts: Sequence[str]) -> str:
    """Return the attribute of a column: words stand left, long ones in several lines; figures stand right."""
    if all(text[:1].isdigit() or text[:1] in "–−∞" for text in texts):
        return ""
    return ' class="text"' if max(map(len, texts)) > _LONG else ' class="word"'


def _row(cells: Sequence[Cell], kinds: Sequence[str]) -> str:
    others = "".join(_cell(cell, kind) for cell, kind in zip(cells[1:], kinds[1:], strict=True))
    return f'<tr><th scope="row">{_content(cells[0])}</th>{others}</tr>'


def _cell(cell: Cell, kind: str) -> str:
    if cell.heat is not None:
        kind = f' class="heat" style="--good:{100 * cell.heat:.0f}%"'
    return f"<td{kind}>{_content(cell)}</td>"


def _content(cell: Cell) -> str:
    return escape(cell.text) + (f"<small>{escape(cell.small)}</small>" if cell.small else "")


def _plot(plot: Plot, command: str) -> str:
    entries = "".join(_entry(entry) for entry in plot.legend)
    legend = f'<ul class="legend">{entries}</ul>' if len(plot.legend) > 1 else ""
    panels = "".join(
        panel.svg.replace("<svg ", f'<svg class="panel" aria-label="{escape(panel.alt)}" ', 1)
        for panel in plot.panels
    )
    caption = f"<figcaption>{_prose(plot.caption)}{_made(command)}</figcaption>"
    kind = "panels" if len(plot.panels) > 1 else "panels one"
    return _block(
        plot.title, f'<figure>{legend}<div class="{kind}">{panels}</div>{caption}</figure>', plot.folded
    )


def _entry(entry: Entry) -> str:
    """Return a line of the legend: a stroke in the colour and dashes of the plot."""
    colour = f"var(--c{entry.colour}, {COLOURS[entry.colour]})"
    dashes = ("", "6 3", "2 2")[entry.dash]
    stroke = f'<path d="M0 5h26" stroke="{colour}" stroke-width="3" stroke-dasharray="{dashes}"/>'
    return f'<li><svg width="26" height="10" aria-hidden="true">{stroke}</svg>{escape(entry.words)}</li>'


def _block(title: str, inside: str, folded: bool) -> str:
    if folded:
        return f'\n<details><summary>{escape(title)}</summary><div class="fold">{inside}</div></details>'
    return f'\n<div class="block"><h3>{escape(title)}</h3>{inside}</div>'


def _prose(text: str) -> str:
    """Return escaped text in which no line begins with a unit."""
    return escape(text).replace(" %", "&nbsp;%")


def _made(command: str) -> str:
    return f'<p class="made">Made by <code>{escape(command)}</code></p>' if command else ""
