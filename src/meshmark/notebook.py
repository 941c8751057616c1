"""Results as notebooks show them: a heading and a small table in HTML, without keys."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

__all__ = ["notebook_table"]


def notebook_table(heading: str, rows: Sequence[tuple[str, str]]) -> str:
    """Return the HTML of a result; every text in it is escaped.

    heading: what it says in a word or two; rows: terms and texts, those without a text are left out.
    """
    cells = "".join(
        f'<tr><th style="text-align:left;font-weight:normal;opacity:.7">{escape(term)}</th>'
        f'<td style="text-align:left">{escape(text)}</td></tr>'
        for term, text in rows
        if text
    )
    return f"<div><strong>{escape(heading)}</strong><table>{cells}</table></div>"
