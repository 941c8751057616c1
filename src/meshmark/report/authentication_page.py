"""The report of an authentication: one HTML page with pictures, a table and plain words, complete in itself."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from meshmark.coding.chance import band, in_words
from meshmark.geometry.surface import Surface
from meshmark.geometry.view import from_behind, three_quarter_view
from meshmark.geometry.weld import weld
from meshmark.io.atomic_write import write_whole
from meshmark.io.staging import Staging
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.report.colours import oklch
from meshmark.report.html import html_page, trusted
from meshmark.report.picture import CLAY, Panel, on_screen, render
from meshmark.report.raster import EMPTY, rasterise

if TYPE_CHECKING:
    from meshmark.authentication.regions.region import Region
    from meshmark.authentication.verdict import Authentication

__all__ = ["altered_colours", "authentication_page", "write_authentication_page"]

SIZE = 640
RED = np.array([0.62, 0.012, 0.012])
"""Linear RGB of what is altered."""
_TITLES = {
    "authentic": "Authentic",
    "surface_intact": "Surface intact, but the file shows something else",
    "altered": "Altered",
    "not_marked": "Not marked with this key",
    "inconclusive": "Inconclusive",
}
_UNSIGNED = "Only the id"
_NEXT = {
    "authentic": "The model is as it was when it was marked. It may have been turned, resized, moved or converted.",
    "surface_intact": "The pictures show the surface alone, which is as it was when it was marked. What a viewer "
    "shows of this file is named above.",
    "altered": "Red is what was moved, made, or exposed by a deletion. <code>meshmark recover</code> brings the "
    "altered parts back, as far as the miniature in the intact part holds them.",
    "not_marked": "Either this model was never marked with this key, or it was changed everywhere.",
    "inconclusive": "A larger part of the model, or its certificate, may tell more.",
}
# Smallest share of a picture that a region takes up to have its number in it.
_LEAST_SEEN = 0.002
_GRID = 200


@dataclass(frozen=True, kw_only=True)
class _Number:
    """A region's number on a picture; x, y: in per cent of its sides, as text."""

    x: str
    y: str
    label: int


@dataclass(frozen=True, kw_only=True)
class _View:
    """A picture, its source an address with the picture in it, and the numbers that lie over it."""

    caption: str
    source: str
    numbers: tuple[_Number, ...]


def write_authentication_page(
    mesh: Mesh, found: Authentication, name: str, path: Path | str, staging: Staging | None = None
) -> None:
    """Save the page of a suspect; name: of its file. Raises `OutputError` where the page cannot be written.

    staging: takes the file, to move it into place together with others.
    """
    write_whole(path, authentication_page(mesh, found, name).encode("utf-8"), staging)


def authentication_page(mesh: Mesh, found: Authentication, name: str) -> str:
    """Return the page; every text in it is escaped."""
    unsigned = found.verdict == "inconclusive" and found.id is not None
    heading = _UNSIGNED if unsigned else _TITLES[found.verdict]
    regions = sorted(
        found.regions, key=lambda region: (region.verdict != "altered", -region.failed, region.id)
    )
    return html_page(
        "authentication.html",
        "report",
        title=f"{name}: {heading}",
        name=name,
        verdict=found.verdict,
        heading=heading,
        advice=found.advice,
        next="" if unsigned else trusted(_NEXT[found.verdict]),
        facts=_facts(mesh, found),
        views=_views(weld(mesh), found),
        size=SIZE,
        regions=regions,
    )


def _facts(mesh: Mesh, found: Authentication) -> list[tuple[str, str]]:
    payload = {"recovered": "read in full", "partial": "damaged", "none": "none"}[found.payload]
    if found.content is not None and found.payload == "recovered":
        payload = f"{found.content.kind}, {len(found.content.content):,} bytes, read in full"
    return [
        ("Size", f"{len(mesh.vertices):,} vertices, {len(mesh.faces):,} faces"),
        (
            "Altered",
            f"{found.altered_vertices:,} vertices, {_percent(found.altered_area_fraction)} of the surface",
        ),
        *(("Shown otherwise", cause.sentence) for cause in found.causes),
        ("Id", "none" if found.id is None else f"{found.id:016x}"),
        ("Payload", payload),
        ("Without the key", _chance(found)),
    ]


def altered_colours(altered: NDArray[np.bool_]) -> FloatArray:
    """Return (n, 3) linear RGB: red for what is altered, clay for the rest."""
    return np.where(altered[:, None], RED, CLAY)


def _views(welded: Surface, found: Authentication) -> list[_View]:
    altered = found.altered[welded.vertex_of_point]
    region = found.region[welded.vertex_of_point]
    colours = altered_colours(altered)
    front = three_quarter_view(welded.points)
    back = from_behind(front)
    plain = Panel(caption="", points=welded.points, faces=welded.faces, colours=colours)
    shades = _shades(found.regions)
    parted = Panel(caption="", points=welded.points, faces=welded.faces, colours=shades, labels=region)
    return [
        _view(plain, front, "From the front, altered parts in red"),
        _view(plain, back, "From behind"),
        _view(parted, front, "Its regions, altered ones in red", region),
        _view(parted, back, "Its regions from behind", region),
    ]


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


def _view(panel: Panel, view: FloatArray, caption: str, region: IntArray | None = None) -> _View:
    numbers = () if region is None else _numbers(panel, view, region)
    return _View(caption=caption, source=_source(render(panel, SIZE, view)), numbers=numbers)


def _source(shown: NDArray[np.uint8]) -> str:
    packed = io.BytesIO()
    Image.fromarray(shown).save(packed, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(packed.getvalue()).decode("ascii")


def _numbers(panel: Panel, view: FloatArray, region: IntArray) -> tuple[_Number, ...]:
    """Return the regions' numbers, where they stand on the picture."""
    _, screen = on_screen(panel.points, panel.faces, _GRID, view)
    seen = rasterise(screen, panel.faces, _GRID, _GRID)
    rows, columns = np.nonzero(seen != EMPTY)
    label = region[panel.faces[seen[rows, columns], 0]]
    numbers = []
    for number in np.unique(label):
        held = label == number
        if held.sum() < _LEAST_SEEN * _GRID**2:
            continue
        y, x = rows[held], columns[held]
        best = int(np.argmin((x - np.median(x)) ** 2 + (y - np.median(y)) ** 2))
        place = (f"{100 * x[best] / _GRID:.1f}", f"{100 * y[best] / _GRID:.1f}")
        numbers.append(_Number(x=place[0], y=place[1], label=int(number)))
    return tuple(numbers)


def _chance(found: Authentication) -> str:
    words = in_words(band(found.log10_false_positive)).replace("^-", "^−")
    return f"chance of such marks {words}" if found.id is not None else "–"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"
