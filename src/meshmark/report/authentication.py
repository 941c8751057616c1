"""The report of an authentication: one HTML page with pictures, a table and plain words, complete in itself."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Sequence
from html import escape
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from meshmark.coding.chance import in_words
from meshmark.geometry.weld import Welded, weld
from meshmark.io.staging import Staging
from meshmark.io.whole import write_whole
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.report.colours import oklch
from meshmark.report.picture import CLAY, Panel, on_screen, render
from meshmark.report.raster import EMPTY, rasterise
from meshmark.report.view import from_behind, three_quarter_view

if TYPE_CHECKING:
    from meshmark.schemes.ncdg_lv.authentication.regions import Region
    from meshmark.schemes.ncdg_lv.authentication.verdict import Authentication

__all__ = ["altered_colours", "authentication_page", "write_authentication_page"]

SIZE = 640
RED = np.array([0.62, 0.012, 0.012])
"""Linear RGB of what is altered."""
_TITLES = {
    "authentic": "Authentic",
    "altered": "Altered",
    "not_marked": "Not marked with this key",
    "inconclusive": "Inconclusive",
}
_UNSIGNED = "Only the id"
_NEXT = {
    "authentic": "The model is as it was when it was marked. It may have been turned, resized, moved or converted.",
    "altered": "Red is what was moved, made, or laid bare by a deletion. <code>meshmark recover</code> brings the "
    "altered parts back, as far as the miniature in the intact part holds them.",
    "not_marked": "Either this model was never marked with this key, or it was changed everywhere.",
    "inconclusive": "A larger part of the model, or its certificate, may tell more.",
}
# Smallest share of a picture that a region takes up to have its number in it.
_LEAST_SEEN = 0.002
_GRID = 200


def write_authentication_page(
    mesh: Mesh, found: Authentication, name: str, path: Path | str, staging: Staging | None = None
) -> None:
    """Save the page of a suspect; name: of its file. Raises `OutputError` where the page cannot be written.

    staging: takes the file, to move it into place together with others.
    """
    write_whole(path, authentication_page(mesh, found, name).encode("utf-8"), staging)


def authentication_page(mesh: Mesh, found: Authentication, name: str) -> str:
    """Return the page; every text in it is escaped."""
    welded = weld(mesh)
    style = resources.files("meshmark").joinpath("report/authentication.css").read_text(encoding="utf-8")
    unsigned = found.verdict == "inconclusive" and found.id is not None
    heading = _UNSIGNED if unsigned else _TITLES[found.verdict]
    title = f"{name}: {heading}"
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f'<link rel="icon" href="data:,">\n<title>{escape(title)}</title>\n<style>\n{style}</style></head>\n'
        f'<body><main class="{found.verdict}">\n<p class="file">{escape(name)}</p>'
        f"<h1>{heading}</h1>\n"
        f'<p class="lead">{_prose(found.advice)}</p>\n<p>{"" if unsigned else _NEXT[found.verdict]}</p>\n'
        f"{_facts(mesh, found)}\n"
        f'<h2>The model</h2>\n<div class="views">{_views(welded, found)}</div>\n'
        f"<h2>Its regions</h2>\n{_table(found.regions)}\n</main></body></html>\n"
    )


def _facts(mesh: Mesh, found: Authentication) -> str:
    payload = {"recovered": "read in full", "partial": "damaged", "none": "none"}[found.payload]
    if found.content is not None and found.payload == "recovered":
        payload = f"{found.content.kind}, {len(found.content.content):,} bytes, read in full"
    rows = [
        ("Size", f"{len(mesh.vertices):,} vertices, {len(mesh.faces):,} faces"),
        (
            "Altered",
            f"{found.altered_vertices:,} vertices, {_percent(found.altered_area_fraction)} of the surface",
        ),
        ("Id", "none" if found.id is None else f"{found.id:016x}"),
        ("Payload", payload),
        ("Without the key", _chance(found)),
    ]
    return "<dl>" + "".join(f"<dt>{name}</dt><dd>{_prose(text)}</dd>" for name, text in rows) + "</dl>"


def altered_colours(altered: NDArray[np.bool_]) -> FloatArray:
    """Return (n, 3) linear RGB: red for what is altered, clay for the rest."""
    return np.where(altered[:, None], RED, CLAY)


def _views(welded: Welded, found: Authentication) -> str:
    altered = found.altered[welded.vertex_of_point]
    region = found.region[welded.vertex_of_point]
    colours = altered_colours(altered)
    front = three_quarter_view(welded.points)
    back = from_behind(front)
    plain = Panel("", welded.points, welded.faces, colours)
    shades = _shades(found.regions)
    parted = Panel("", welded.points, welded.faces, shades, labels=region)
    return (
        _figure(plain, front, "From the front, altered parts in red")
        + _figure(plain, back, "From behind")
        + _figure(parted, front, "Its regions, altered ones in red", region)
        + _figure(parted, back, "Its regions from behind", region)
    )


def _shades(regions: Sequence[Region]) -> FloatArray:
    """Return (k, 3) linear RGB: reds for altered regions, greys of three shades for the others."""
    count = len(regions)
    called = np.array([region.verdict == "altered" for region in regions], bool)
    step = np.arange(count) % 3
    red, grey = (
        oklch(0.55 + 0.05 * step, 0.17, np.full(count, 27.0)),
        oklch(0.80 + 0.05 * step, 0.012, np.full(count, 95.0)),
    )
    return np.where(called[:, None], red, grey)


def _figure(panel: Panel, view: FloatArray, caption: str, region: IntArray | None = None) -> str:
    shown = render(panel, SIZE, view)
    numbers = "" if region is None else _numbers(panel, view, region)
    return (
        f'<figure><div class="shot"><img src="{_source(shown)}" alt="{escape(caption)}" width="{SIZE}" '
        f'height="{SIZE}">{numbers}</div><figcaption>{escape(caption)}</figcaption></figure>'
    )


def _source(shown: NDArray[np.uint8]) -> str:
    packed = io.BytesIO()
    Image.fromarray(shown).save(packed, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(packed.getvalue()).decode("ascii")


def _numbers(panel: Panel, view: FloatArray, region: IntArray) -> str:
    """Return the regions' numbers as a drawing that lies over the picture."""
    _, screen = on_screen(panel.points, panel.faces, _GRID, view)
    seen = rasterise(screen, panel.faces, _GRID, _GRID)
    rows, columns = np.nonzero(seen != EMPTY)
    label = region[panel.faces[seen[rows, columns], 0]]
    parts = []
    for number in np.unique(label):
        held = label == number
        if held.sum() < _LEAST_SEEN * _GRID**2:
            continue
        y, x = rows[held], columns[held]
        best = int(np.argmin((x - np.median(x)) ** 2 + (y - np.median(y)) ** 2))
        at = f'cx="{100 * x[best] / _GRID:.1f}" cy="{100 * y[best] / _GRID:.1f}"'
        parts.append(f'<circle {at} r="2"/><text {at.replace("cx", "x").replace("cy", "y")}>{number}</text>')
    return f'<svg viewBox="0 0 100 100" aria-hidden="true">{"".join(parts)}</svg>'


def _table(regions: Sequence[Region]) -> str:
    regions = sorted(regions, key=lambda region: (region.verdict != "altered", -region.failed, region.id))
    rows = "\n".join(
        f'<tr><th scope="row">{region.id}</th><td class="word">{region.where}</td>'
        f'<td class="word {region.verdict}">{region.verdict}</td><td>{region.probability:.4f}</td>'
        f"<td>{region.checks:,}</td><td>{region.failed:,}</td></tr>"
        for region in regions
    )
    return (
        '<div class="scroll"><table><thead><tr><th scope="col">Region</th><th scope="col" class="word">Where</th>'
        '<th scope="col" class="word">Verdict</th><th scope="col">Probability</th><th scope="col">Checks</th>'
        f'<th scope="col">Failed</th></tr></thead><tbody>\n{rows}</tbody></table></div>'
        '<p class="note">Altered regions first. Where: the altered part of it, else its middle, as the '
        "pictures from the front show it. Probability: that "
        "the region was altered. Checks: places in it that could be told; failed: those that are altered.</p>"
    )


def _chance(found: Authentication) -> str:
    words = in_words(found.log10_false_positive).replace("^-", "^−")
    return f"chance of such marks {words}" if found.id is not None else "–"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def _prose(text: str) -> str:
    return re.sub(r"\^(−?\d+)", r"<sup>\1</sup>", escape(text).replace(" %", "&nbsp;%"))
