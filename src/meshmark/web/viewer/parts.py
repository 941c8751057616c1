"""The files of the viewer, for pages that hold them or serve them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

__all__ = ["ViewerParts", "viewer_parts"]

FOLDER = Path(__file__).parent
"""Holds `viewer.bundle.js` and `viewer.css`."""


@dataclass(frozen=True, kw_only=True)
class ViewerParts:
    """The viewer as text.

    script: an ES module that exports `createViewer(element, view)`, with three.js and its licence. It also starts
    a viewer in each element of its page with `data-view="ID"`, ID being that of a script element of type
    application/json that holds a view (`meshmark.report.surface_view`), and lets buttons with `data-theme-switch`
    choose light or dark.
    style: its style sheet.
    """

    script: str
    style: str


@cache
def viewer_parts() -> ViewerParts:
    """Return the files of the viewer."""
    return ViewerParts(
        script=(FOLDER / "viewer.bundle.js").read_text(encoding="utf-8"),
        style=(FOLDER / "viewer.css").read_text(encoding="utf-8"),
    )
