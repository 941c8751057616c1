"""Pictures of models: panels side by side, each a lit surface with a caption, saved as PNG."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from meshmark.geometry.view import three_quarter_view
from meshmark.io.atomic_write import write_whole
from meshmark.io.paint import Paint
from meshmark.io.staging import Staging
from meshmark.mesh import FloatArray, IntArray
from meshmark.report.colours import heat, to_srgb
from meshmark.report.painted import painted_at
from meshmark.report.raster import rasterise
from meshmark.report.shade import Seen, light, see

__all__ = ["Bar", "Panel", "on_screen", "panels", "render"]

FINER = 2
"""Samples per pixel and axis."""
MARGIN = 0.07
CLAY = np.array([0.70, 0.69, 0.66])
PAPER = (np.array([1.0, 1.0, 1.0]), np.array([0.86, 0.88, 0.91]))
"""Linear RGB of the background, top and bottom."""
INK = (38, 42, 48)


@dataclass(frozen=True, eq=False, kw_only=True)
class Panel:
    """One view of a surface.

    colours: None for clay; linear RGB in [0, 1], (p, 3) per point or (m, 3) per face; (k, 3) with `labels`.
    paint:   of the faces, by which the colours are multiplied; without colours, its own.
    labels:  (p,) region of each point, an index into `colours`; borders are drawn between regions.
    marks:   points to draw as dots where they are seen.
    """

    caption: str
    points: FloatArray
    faces: IntArray
    colours: FloatArray | None = None
    paint: Paint | None = None
    labels: IntArray | None = None
    marks: IntArray | None = None


@dataclass(frozen=True, kw_only=True)
class Bar:
    """A colour bar of `heat`; ticks: the place of each number along it, 0 to 1, and its label."""

    title: str
    ticks: tuple[tuple[float, str], ...]


def panels(
    shown: Sequence[Panel],
    path: Path | str,
    *,
    size: int = 900,
    view: FloatArray | None = None,
    bar: Bar | None = None,
    columns: int | None = None,
    staging: Staging | None = None,
) -> None:
    """Draw `shown` side by side, each `size` pixels square, and save the PNG.

    columns: of a row, all in one row if None.

    view: rotation (3, 3) for all panels, rows right, up, towards the viewer; by default a three-quarter view
          of the first panel's model, so that a turned copy beside it is seen turned.
    bar:  a colour bar under the panels, for values coloured with `heat`.

    staging: takes the file, to move it into place together with others.

    Raises `OutputError` where the file cannot be written.
    """
    turn = three_quarter_view(shown[0].points) if view is None else view
    strip = max(40, size // 15)
    across = len(shown) if columns is None else min(columns, len(shown))
    rows, row = -(-len(shown) // across), size + strip
    sheet = Image.new("RGB", (size * across, row * rows + (strip if bar else 0)), "white")
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(size=max(14, size // 38))
    for i, panel in enumerate(shown):
        left, top = i % across * size, i // across * row
        sheet.paste(Image.fromarray(render(panel, size, turn)), (left, top))
        draw.text((left + size / 2, top + size + strip / 2), panel.caption, INK, font, "mm")
    if bar:
        _draw_bar(sheet, bar, row * rows, strip, font)
    packed = io.BytesIO()
    sheet.save(packed, "PNG")
    write_whole(path, packed.getvalue(), staging)


def render(panel: Panel, size: int, view: FloatArray) -> NDArray[np.uint8]:
    """Return (size, size, 3) sRGB bytes: the panel's model filling the square."""
    fine = size * FINER
    viewed, screen = on_screen(panel.points, panel.faces, fine, view)
    seen = see(rasterise(screen, panel.faces, fine, fine), screen, viewed, panel.faces)
    blend = np.linspace(0.0, 1.0, fine)[:, None, None] ** 1.5
    paper = (1.0 - blend) * PAPER[0] + blend * PAPER[1]
    image = np.broadcast_to(paper.astype(np.float32), (fine, fine, 3)).copy()
    image[seen.mask] = np.minimum(light(seen, _colours(panel, seen).astype(np.float32)), 1.0)
    if panel.labels is not None:
        image[_borders(seen, _nearest_corner(seen, panel.labels))] *= 0.25
    small = np.mean([image[i::FINER, j::FINER] for i in range(FINER) for j in range(FINER)], axis=0)
    picture = to_srgb(small)
    return picture if panel.marks is None else _dots(picture, panel.marks, screen / FINER, seen)


def on_screen(
    points: FloatArray, faces: IntArray, size: int, view: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return points (p, 3) turned by the view, in pixels, and their places (p, 3) on a square of `size` pixels that
    the model fills, depth in [0, 1] as `rasterise` takes it.
    """
    used = np.unique(faces) if len(faces) else np.arange(len(points))
    viewed = points @ view.T
    low, high = viewed[used].min(axis=0), viewed[used].max(axis=0)
    scale = size * (1.0 - 2.0 * MARGIN) / (max(high[0] - low[0], high[1] - low[1]) or 1.0)
    middle = (low + high) / 2.0
    screen = np.empty_like(viewed)
    screen[:, 0] = (viewed[:, 0] - middle[0]) * scale + size / 2.0
    screen[:, 1] = (middle[1] - viewed[:, 1]) * scale + size / 2.0
    screen[:, 2] = 0.01 + 0.9 * (high[2] - viewed[:, 2]) * scale / (size * 3.0)
    screen[:, 2] = np.clip(screen[:, 2], 0.0, 1.0)
    return (viewed - middle) * scale, screen


def _colours(panel: Panel, seen: Seen) -> FloatArray:
    """Return (k, 3): the colour of the surface at each pixel that shows it."""
    if panel.paint is None:
        return _plain_colours(panel, seen)
    painted = painted_at(panel.paint, seen.face, seen.weights.astype(np.float64))
    return painted if panel.colours is None else painted * _plain_colours(panel, seen)


def _plain_colours(panel: Panel, seen: Seen) -> FloatArray:
    if panel.colours is None:
        return np.broadcast_to(CLAY, (len(seen.face), 3))
    if panel.labels is not None:
        return panel.colours.take(_nearest_corner(seen, panel.labels), axis=0)
    if len(panel.colours) == len(panel.points):
        at = panel.colours.take(seen.faces, axis=0)
        blended: FloatArray = np.einsum("kc,kci->ki", seen.weights, at)
        return blended
    return panel.colours.take(seen.face, axis=0)


def _nearest_corner(seen: Seen, labels: IntArray) -> IntArray:
    nearest = np.take_along_axis(seen.faces, seen.weights.argmax(axis=1)[:, None], axis=1)[:, 0]
    return labels[nearest]


def _borders(seen: Seen, labels: IntArray) -> NDArray[np.bool_]:
    """Return (height, width): pixels next to another region of the same piece of surface."""
    plane = np.full(seen.mask.shape, -1, np.int64)
    plane[seen.mask] = labels
    border = np.zeros(plane.shape, bool)
    for axis in (0, 1):
        here, there = plane, np.roll(plane, -1, axis=axis)
        differs = (here != there) & (here >= 0) & (there >= 0)
        border |= differs | np.roll(differs, 1, axis=axis)
    return border


def _dots(picture: NDArray[np.uint8], marks: IntArray, screen: FloatArray, seen: Seen) -> NDArray[np.uint8]:
    """Draw a dot at each of the points `marks` that nothing hides."""
    depth = np.full(seen.mask.shape, np.inf)
    depth[seen.mask] = seen.depth
    image = Image.fromarray(picture)
    draw = ImageDraw.Draw(image)
    radius = len(picture) / 220.0
    size = len(depth)
    for x, y, z in screen[marks]:
        row, column = int(np.clip(y * FINER, 0, size - 1)), int(np.clip(x * FINER, 0, size - 1))
        around = depth[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
        if z * FINER <= around.max(initial=0.0, where=np.isfinite(around)) + 0.004:
            draw.ellipse([x - radius, y - radius, x + radius, y + radius], (20, 110, 190), "white", 1)
    return np.asarray(image)


def _draw_bar(
    sheet: Image.Image, bar: Bar, top: int, strip: int, font: ImageFont.FreeTypeFont | ImageFont.ImageFont
) -> None:
    """Draw a colour bar under the panels."""
    draw = ImageDraw.Draw(sheet)
    length = sheet.width * 2 // 5
    left = sheet.width // 2 - length // 3
    ramp = to_srgb(heat(np.linspace(0.0, 1.0, length)))[None]
    sheet.paste(Image.fromarray(np.repeat(ramp, strip // 3, axis=0)), (left, top + 2))
    draw.text((left - 14, top + 2 + strip / 6), bar.title, INK, font, "rm")
    for at, label in bar.ticks:
        x = left + at * (length - 1)
        draw.line([x, top + strip / 3 + 2, x, top + strip / 3 + 6], INK)
        draw.text((x, top + strip / 3 + 8), label, INK, font, "ma")
