"""The page of a report: verdict, view, numbers, what they mean, and where they come from, in one HTML file.

Nothing comes by network: a Content-Security-Policy allows the page its own style, its own script and pictures
within.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from meshmark.io.atomic_write import write_whole
from meshmark.io.staging import Staging
from meshmark.report.html import html_page, trusted
from meshmark.report.meaning import MEANINGS
from meshmark.report.view_script import GET_IT, view_script

if TYPE_CHECKING:
    from meshmark.authentication.regions.region import Region
    from meshmark.report.provenance import Provenance
    from meshmark.report.still_view import StillView

__all__ = ["Report", "Table", "report_page", "write_report_page"]


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of a report; rows: cells as text, the first is the row's head. words: number of columns, from the
    left, that hold words and not figures."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: int = 1
    note: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class Report:
    """What a page says.

    kind: "Authentication", "Extraction", ...; answer: a key of `MEANINGS`. tone: "good", "bad" or "open", the
    colour of the heading. heading: the answer in plain words; lead: the sentences that follow, next: what to do.
    facts: terms and texts. sure: how sure, and why. view: of `surface_view`, None for none. pictures: stills.
    regions: of a
    table of that title.
    """

    kind: str
    answer: str
    tone: str
    heading: str
    lead: str
    next: str
    facts: Sequence[tuple[str, str]]
    sure: Sequence[str]
    provenance: Provenance
    view: dict[str, Any] | None = None
    pictures: Sequence[StillView] = ()
    regions: Sequence[Region] = ()
    regions_title: str = "Regions"
    tables: Sequence[Table] = ()


def write_report_page(report: Report, path: Path | str, staging: Staging | None = None) -> None:
    """Save the page; raises `OutputError` where it cannot be written.

    staging: takes the file, to move it into place together with others.
    """
    write_whole(path, report_page(report).encode("utf-8"), staging)


def report_page(report: Report) -> str:
    """Return the page; every text in it is escaped."""
    viewer = view_script() if report.view is not None else None
    own = (resources.files("meshmark") / "report" / "templates" / "report.css").read_text(encoding="utf-8")
    style = own if viewer is None else f"{own}\n{viewer.style}"
    script = "" if viewer is None else viewer.script
    return html_page(
        "report.html",
        "report",
        title=f"{report.provenance.name}: {report.heading}",
        report=report,
        meaning=MEANINGS[report.answer],
        style=trusted(style),
        script=trusted(script),
        policy=_policy(style, script),
        view=trusted(_json(report.view)) if viewer is not None else "",
        get_it=GET_IT if report.view is not None and viewer is None else "",
        trusted=trusted,
    )


def _json(view: dict[str, Any] | None) -> str:
    """Return a view as JSON that can stand in a script element."""
    return json.dumps(view, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _policy(style: str, script: str) -> str:
    """Return the Content-Security-Policy that allows this style, this script, and pictures within the page."""
    scripts = f"'{_sha256(script)}'" if script else "'none'"
    return (
        f"default-src 'none'; img-src data:; style-src '{_sha256(style)}'; script-src {scripts}; "
        "base-uri 'none'; form-action 'none'"
    )


def _sha256(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
