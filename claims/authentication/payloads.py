"""Payload: how much payload there is, when it is read back, and an image byte by byte."""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np
from PIL import Image

import meshmark as mm
from claims.authentication.figures import Row
from claims.authentication.subjects import KEY, Subject
from meshmark.attacks.crop import without
from meshmark.attacks.local_patch import draw_patch
from meshmark.authentication.checks.checks import check
from meshmark.authentication.payload.payload import capacity
from meshmark.geometry.areas import vertex_areas
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, Mesh

__all__ = ["measure"]


def measure(subject: Subject, _draws: int | None) -> Iterator[Row]:
    name, rng, count = subject.name, subject.rng("payload"), len(subject.surface.points)
    found = check(weld(subject.upper.mesh), KEY)
    net = 8.0 * capacity(len(np.unique(found.carried.index)), found.symbol_bits) / count
    yield Row("payload at 55 % of the marks, bits per point", name, "", net)
    image = _image(count // 8, rng)
    try:
        full = mm.embed(subject.mesh, KEY, id=3, layers="both", payload=image)
    except mm.CapacityError as error:
        print(f"  image: {error}")
        yield Row("image byte by byte", name, str(error), False)
        return
    content = mm.authenticate(full.mesh, KEY).content
    yield Row("image byte by byte", name, "", content is not None and content.content == image)
    yield Row("PSNR with both layers", name, "", full.psnr_db)
    areas = vertex_areas(subject.surface.points, subject.surface.faces)
    for words, weights in (("surface", areas), ("points", np.ones(count))):
        left = _connected(full.mesh, 0.6, weights, rng)
        yield Row(f"1 bit per point read from a connected 60 % of the {words}", name, "", _reads(left, image))
    small = rng.bytes(count // 16)
    half = mm.embed(subject.mesh, KEY, id=4, layers="authentication", payload=small).mesh
    surface = weld(half)
    passed = check(surface, KEY).passed
    for words, able in (("the marks", passed), ("all points", np.ones(len(surface.points), bool))):
        moved = _scattered(half, able, rng)
        yield Row(f"half of that from 40 % of {words}, scattered", name, "", _reads(moved, small))


def _image(size: int, rng: np.random.Generator) -> bytes:
    """Return a PNG thumbnail of exactly this number of bytes; what is left to fill follows its end."""
    side = int(np.sqrt(size))
    while True:
        packed = io.BytesIO()
        Image.fromarray(rng.integers(0, 256, (side, side), np.uint8)).save(packed, "PNG")
        if len(packed.getvalue()) <= size:
            return packed.getvalue().ljust(size, b"\0")
        side -= 1


def _connected(mesh: Mesh, share: float, weights: FloatArray, rng: np.random.Generator) -> Mesh:
    """Return what lies nearest to a random point along the surface, up to a share of the points' weights (p,)."""
    patch = draw_patch(mesh, 0.9999, rng)
    count = int(np.searchsorted(np.cumsum(weights[patch.members]), share * weights.sum()))
    kept = np.zeros(len(weights), bool)
    kept[patch.members[:count]] = True
    return without(mesh, ~kept[patch.welded.point_of_vertex]).mesh


def _scattered(mesh: Mesh, able: np.ndarray, rng: np.random.Generator) -> Mesh:
    """Move 60 % of the points that are `able` (p,) by a tenth of the mean edge or so."""
    surface = weld(mesh)
    edges = surface.points[surface.faces[:, 0]] - surface.points[surface.faces[:, 1]]
    chosen = np.flatnonzero(able)
    chosen = rng.permutation(chosen)[: round(0.6 * len(chosen))]
    points = surface.points.copy()
    points[chosen] += 0.1 * np.linalg.norm(edges, axis=1).mean() * rng.normal(size=(len(chosen), 3))
    return mesh.with_vertices(points[surface.point_of_vertex])


def _reads(mesh: Mesh, content: bytes) -> bool:
    found = mm.authenticate(mesh, KEY)
    return found.content is not None and found.content.content == content
