"""The viewer that pages hold: files of the wheel meshmark-web, where it is installed."""

from __future__ import annotations

from functools import cache
from typing import Protocol

__all__ = ["ENTRY_POINTS", "GET_IT", "ViewScript", "view_script"]

ENTRY_POINTS = "meshmark.viewer"
"""The group of entry points under which the wheel meshmark-web registers the viewer."""
GET_IT = "pip install meshmark[web]"
"""Adds it to an installation."""


class ViewScript(Protocol):
    """script: an ES module that starts a viewer in each element with data-view; style: its style sheet."""

    @property
    def script(self) -> str:
        """Return the text of the module, which holds no closing script tag."""
        ...

    @property
    def style(self) -> str:
        """Return the text of the style sheet."""
        ...


@cache
def view_script() -> ViewScript | None:
    """Return the viewer, None where the wheel meshmark-web is not installed."""
    from importlib.metadata import entry_points

    for point in entry_points(group=ENTRY_POINTS):
        found: ViewScript = point.load()()
        return found
    return None
