"""Make the pictures of docs/design.md of the included hare: .venv/bin/python tools/make_design_pictures.py.

Lattice cells and pilots, marks and their rings, all under a key of 32 zero bytes, as JPEG; the quantiser as SVG.
Saliency and regions are those of the gallery (tools/make_gallery.py).
"""

from __future__ import annotations

import tempfile
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

import meshmark as mm
from meshmark.authentication.marks.planning import plans
from meshmark.coding.codec import Codec
from meshmark.data import hare_ply
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.view import three_quarter_view
from meshmark.io import read_mesh_from
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.report.colours import oklch, region_colours
from meshmark.report.picture import CLAY, Panel, panels

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images" / "design"
WIDTH, QUALITY = 1500, 82
ID = 0x0123456789ABCDEF
BITS = oklch(np.array([0.62, 0.80, 0.55]), np.array([0.13, 0.12, 0.02]), np.array([255.0, 75.0, 255.0]))
"""Colours of what carries a 0, a 1, and of pilots."""
ZERO, ONE = "#2f6fc4", "#d9822b"
MARK, RING = oklch(np.array([0.50, 0.85]), np.array([0.18, 0.07]), np.array([25.0, 75.0]))


def keep(shown: list[Panel], name: str) -> None:
    """Draw panels into the docs, as a JPEG of at most WIDTH pixels."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        panels(shown, path)
        with Image.open(path) as picture:
            small = picture.convert("RGB")
    small.thumbnail((WIDTH, WIDTH))
    small.save(IMAGES / f"{name}.jpg", quality=QUALITY, optimize=True)


def cells(mesh: mm.Mesh, key: mm.Key) -> None:
    """Draw the cells of the keyed lattice on the surface, and what each carries."""
    certificate = mm.embed(mesh, key, id=ID, layers="ownership").certificate
    lattice = Lattice.keyed(key, certificate.spacing, Label.of_hex(certificate.lattice))
    surface = surface_of(mesh)
    points, faces = surface.points, surface.faces
    at = lattice.coordinates(canonical_frame(points, faces).to_canonical(points))
    nodes, cell = np.unique(np.round(at).astype(np.int64), axis=0, return_inverse=True)
    keys = lattice.keys(nodes)
    kind = np.where(keys.pilot, 2, Codec(key).encode(ID)[keys.code_index])
    carry = Panel(
        caption="what each carries: 0 blue, 1 orange, pilots grey",
        points=points,
        faces=faces,
        colours=BITS[kind],
        labels=cell,
    )
    shades = region_colours(cell, faces, len(nodes))
    drawn = Panel(
        caption=f"{len(nodes)} cells of the keyed lattice",
        points=points,
        faces=faces,
        colours=shades,
        labels=cell,
    )
    keep([drawn, carry], "cells")


def marks(mesh: mm.Mesh, key: mm.Key) -> None:
    """Draw the points that carry authentication marks, and their rings; the whole, and the head from near."""
    plan = next(plans(mesh, key, None)).plan
    points, faces = plan.surface.points, plan.surface.faces
    is_mark = np.zeros(len(points), bool)
    is_mark[plan.marks] = True
    in_ring = np.zeros(len(points), bool)
    in_ring[faces[is_mark[faces].any(axis=1)]] = True
    colours = np.where(is_mark[:, None], MARK, np.where(in_ring[:, None], RING, CLAY))
    towards = points @ three_quarter_view(points).T
    middle = towards[faces].mean(axis=1)
    from_centre = np.linalg.norm(middle[:, :2] - np.median(towards[:, :2], axis=0), axis=1)
    front = middle[from_centre < 0.1 * np.ptp(towards[:, 1])]
    seen = front[front[:, 2].argmax()]
    near = faces[np.linalg.norm(middle - seen, axis=1) < 0.1 * np.ptp(towards[:, 1])]
    kinds = np.where(is_mark, 0, np.where(in_ring, 1, 2))
    shades = np.array([MARK, RING, CLAY])
    share = f"{is_mark.sum():,} marks on {len(points):,} points"
    keep(
        [
            Panel(caption=share, points=points, faces=faces, colours=colours),
            Panel(
                caption="from near: marks red, their rings pale",
                points=points,
                faces=near,
                colours=shades,
                labels=kinds,
            ),
        ],
        "marks",
    )


def quantiser() -> str:
    """Return a diagram of quantisation index modulation as SVG."""
    left, step, top, low = 60, 140, 96, 148
    at, to, other = left + 2.68 * step, left + 2.5 * step, left + 3 * step
    points = ""
    for k in range(9):
        x, bit = left + k * step // 2, k % 2
        square = f'<rect x="{x - 6}" y="{top - 6}" width="12" height="12" fill="{ONE}"/>'
        points += square if bit else f'<circle cx="{x}" cy="{top}" r="7" fill="{ZERO}"/>'
        points += f'<text x="{x}" y="{top + 30}" text-anchor="middle">{bit}</text>'
    tips = "".join(
        f'<marker id="{name}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="5" markerHeight="5" '
        f'orient="auto"><path d="M0 0 L8 4 L0 8 z" fill="{colour}"/></marker>'
        for name, colour in (("one", ONE), ("zero", ZERO))
    )
    way = f"M{at} {top - 20} L"
    lines = (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 680 184" font-family="sans-serif"',
        ' font-size="14" fill="#222" role="img">',
        "<title>Quantisation index modulation: an offset moves to the nearest point of its bit</title>",
        f'<rect width="680" height="184" fill="#fff"/><defs>{tips}',
        '<marker id="bar" viewBox="0 0 2 10" refX="1" refY="5" markerWidth="2" markerHeight="10">',
        '<path d="M1 0 V10" stroke="#333"/></marker></defs>',
        f'<path d="M30 {top} H650" stroke="#999"/>{points}',
        f'<path d="M{at} {top - 34} V{top - 6}" stroke="#333" stroke-width="2"/>',
        f'<text x="{at + 4}" y="{top - 42}" text-anchor="middle">offset s of a cell</text>',
        f'<path d="{way}{to + 6} {top - 20}" stroke="{ONE}" stroke-width="3" marker-end="url(#one)"/>',
        f'<path d="{way}{other - 6} {top - 20}" stroke="{ZERO}" stroke-width="3" stroke-dasharray="5 4"',
        ' marker-end="url(#zero)"/>',
        f'<text x="{to - 2}" y="{top - 28}" text-anchor="end" fill="#a85d12">for bit 1</text>',
        f'<text x="{other + 2}" y="{top - 28}" fill="{ZERO}">for bit 0</text>',
        f'<path d="M{left} {low} H{left + step}" stroke="#333"',
        ' marker-start="url(#bar)" marker-end="url(#bar)"/>',
        f'<text x="{left + step / 2}" y="{low + 20}" text-anchor="middle">one step</text>',
        f'<text x="{left + 1.4 * step}" y="{low + 4}">',
        "points of step (Z + dither + b/2); the dither is the key's</text></svg>\n",
    )
    return "".join(lines)


def main() -> None:
    """Write docs/images/design."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    mesh, key = read_mesh_from(BytesIO(hare_ply()), "ply"), mm.Key(bytes(32))
    (IMAGES / "quantiser.svg").write_text(quantiser(), encoding="utf-8")
    cells(mesh, key)
    marks(mesh, key)


if __name__ == "__main__":
    main()
