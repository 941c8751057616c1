"""A report as Markdown that also reads well as plain text."""

from __future__ import annotations

from collections.abc import Sequence

from meshmark.research.benchmark.page.report_parts import Cell, Plot, Section, Table

__all__ = ["markdown"]

# Columns with longer cells are text: they stand at the left and are not padded, or no line could be read.
_WIDEST = 44


def markdown(title: str, sections: Sequence[Section], command: str, folder: str) -> str:
    """Return the text of the report; `folder` holds the pictures, `command` made every table and plot."""
    blocks = [f"# {title}"]
    for section in sections:
        blocks += [f"## {section.title}", *(_escape(words) for words in section.words)]
        for part in section.parts:
            blocks += _table(part, command) if isinstance(part, Table) else _plot(part, command, folder)
    return "\n\n".join(blocks) + "\n"


def _table(table: Table, command: str) -> list[str]:
    head = [f"### {_escape(table.title)}"]
    note = [_escape(table.note)] if table.note else []
    if not table.rows:
        return [*head, "Nothing to show."]
    lines = [
        [_escape(name) for name in table.columns],
        *([_cell(cell) for cell in row] for row in table.rows),
    ]
    widths = [max(3, *(len(line[i]) for line in lines)) for i in range(len(table.columns))]
    numbers = [i > 0 and width <= _WIDEST for i, width in enumerate(widths)]
    widths = [width if width <= _WIDEST else 3 for width in widths]
    rule = "|".join(
        "-" * (width + 1) + (":" if right else "-") for width, right in zip(widths, numbers, strict=True)
    )
    text = [_line(line, widths, numbers) for line in lines]
    text.insert(1, f"|{rule}|")
    return [*head, "\n".join(text), *note, _made(command)]


def _plot(plot: Plot, command: str, folder: str) -> list[str]:
    pictures = [f"![{_escape(panel.alt)}]({folder}/{panel.name}.svg)" for panel in plot.panels]
    if len(plot.legend) > 1:
        pictures.insert(0, f"![Legend]({folder}/{plot.panels[0].name}-legend.svg)")
    return [f"### {_escape(plot.title)}", _escape(plot.caption), "\n".join(pictures), _made(command)]


def _made(command: str) -> str:
    return f"Made by `{command}`." if command else ""


def _line(cells: Sequence[str], widths: Sequence[int], numbers: Sequence[bool]) -> str:
    padded = (
        text.rjust(width) if right else text.ljust(width)
        for text, width, right in zip(cells, widths, numbers, strict=True)
    )
    return f"| {' | '.join(padded)} |"


def _cell(cell: Cell) -> str:
    return _escape(f"{cell.text} ({cell.small})" if cell.small else cell.text)


def _escape(text: str) -> str:
    """Return text that Markdown and the HTML it becomes show as it is."""
    plain = " ".join(text.split()).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    for sign in "\\|`*[]":
        plain = plain.replace(sign, "\\" + sign)
    return plain
