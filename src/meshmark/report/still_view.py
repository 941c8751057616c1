"""Still pictures for a page: PNG addresses of data, with the numbers of regions over them."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from meshmark.geometry.view import from_behind
from meshmark.mesh import FloatArray, IntArray
from meshmark.report.picture import Panel, on_screen, render
from meshmark.report.raster import EMPTY, rasterise

__all__ = ["SIZE", "Number", "StillView", "front_and_back", "still_view"]

SIZE = 560
"""Pixels, each way."""
# Smallest share of a picture that a region takes up to have its number in it.
_LEAST_SEEN = 0.002
_GRID = 200


@dataclass(frozen=True, kw_only=True)
class Number:
    """A region's number on a picture; x, y: in per cent of its sides, as text."""

    x: str
    y: str
    label: int


@dataclass(frozen=True, kw_only=True)
class StillView:
    """A picture, its source an address with the picture in it, and the numbers that lie over it."""

    caption: str
    source: str
    size: int
    numbers: tuple[Number, ...] = ()


def front_and_back(
    panel: Panel, view: FloatArray, captions: tuple[str, str], *, numbered: bool = False
) -> list[StillView]:
    """Return the pictures of a panel from a view (3, 3) and from behind; numbered: with the numbers of its
    labels."""
    views = (view, from_behind(view))
    return [
        still_view(panel, way, caption, numbered=numbered)
        for way, caption in zip(views, captions, strict=True)
    ]


def still_view(panel: Panel, view: FloatArray, caption: str, *, numbered: bool = False) -> StillView:
    """Return the picture of a panel from a view (3, 3)."""
    numbers = _numbers(panel, view, panel.labels) if numbered and panel.labels is not None else ()
    return StillView(caption=caption, source=_source(render(panel, SIZE, view)), size=SIZE, numbers=numbers)


def _source(shown: NDArray[np.uint8]) -> str:
    packed = io.BytesIO()
    Image.fromarray(shown).save(packed, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(packed.getvalue()).decode("ascii")


def _numbers(panel: Panel, view: FloatArray, region: IntArray) -> tuple[Number, ...]:
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
        numbers.append(Number(x=place[0], y=place[1], label=int(number)))
    return tuple(numbers)
