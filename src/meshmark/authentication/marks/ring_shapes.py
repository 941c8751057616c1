"""Where a point lies in the frame of its ring, and how firmly the ring holds that frame.

All is invariant to similarity transforms and to the order of points and faces (docs/design.md, section 7). The ring
alone makes the frame: a ring that stays, while its middle point moves, gives the same frame again.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import AnyIntArray, rows_of
from meshmark.authentication.marks.rings import Rings
from meshmark.authentication.parameters import FINE, Style
from meshmark.geometry.blocks import blocks
from meshmark.mesh import FloatArray, IntArray

__all__ = ["RingShapes", "frames", "in_style", "ring_shapes", "spreads_from", "starts"]

_TINY = 1e-30
# Points of marks without pull lie about this far, in ring sizes, from the middle that turns them.
_LIFT = 0.3
# Rings whose shapes are made at once: those of a large model would take gigabytes meanwhile.
_BLOCK = 1 << 16


@dataclass(frozen=True, eq=False, kw_only=True)
class RingShapes:
    """Shapes of r rings of k neighbours.

    points: (p, 3) of the surface; around: (r, k) the neighbours among them. centre: (r, 3) mean of the neighbours.
    size: (r,) their RMS distance from it, in scene units; 0 where they coincide. normal: (r, 3) unit, of the
    polygon's area vector; zeros where it has none. distance: (r, k) lengths of the offsets. chord: (r, k)
    from each neighbour to the next. spread: (r,) how much an error of one coordinate of every neighbour and of
    the middle point grows in the point's place in the ring, a factor of standard deviations. sway: (r,) how much
    such an error turns the ring's frame, in radians for an error of one ring size: large where it is a needle.
    swing: (r,) how much the error of the frame moves the place of the middle point itself, over the spread, which
    takes it to lie near the middle of the ring: the more the farther it lies. style: of the marks of the spread.
    """

    points: FloatArray
    around: NDArray[np.int32]
    centre: FloatArray
    size: FloatArray
    normal: FloatArray
    distance: FloatArray
    chord: FloatArray
    spread: FloatArray
    sway: FloatArray
    swing: FloatArray
    style: Style = FINE

    def take(self, rows: IntArray | NDArray[np.bool_] | slice) -> RingShapes:
        """Return these rows."""
        taken: dict[str, Any] = {name: rows_of(getattr(self, name), rows) for name in ("around", *_MEASURED)}
        return replace(self, **taken)

    def offsets(self, rows: AnyIntArray | slice, order: AnyIntArray | None = None) -> FloatArray:
        """Return (n, k, 3): the neighbours of some rings less the centre, in units of the size.

        order: (n, k) in which to take them. They would take more room than all else, and are quickly made.
        """
        around = rows_of(self.around, rows)
        around = around if order is None else np.take_along_axis(around, order, 1)
        offsets = self.points.take(around, axis=0) - rows_of(self.centre, rows)[:, None]
        offsets /= np.maximum(rows_of(self.size, rows), _TINY)[:, None, None]
        return offsets


_MEASURED = tuple(
    field.name for field in fields(RingShapes) if field.name not in ("points", "around", "style")
)


def ring_shapes(points: FloatArray, rings: Rings, style: Style = FINE) -> RingShapes:
    """Return the shapes of rings, of points (p, 3), for marks of a style."""
    if len(rings.vertex) <= _BLOCK:
        return _shapes(points, rings, style)
    whole: dict[str, FloatArray] = {}
    for block in blocks(len(rings.vertex), _BLOCK):
        part = _shapes(points, rings.take(block), style)
        for name in _MEASURED:
            found = getattr(part, name)
            if name not in whole:
                whole[name] = np.empty((len(rings.vertex), *found.shape[1:]))
            whole[name][block] = found
    return RingShapes(points=points, around=rings.around, **whole, style=style)


def _shapes(points: FloatArray, rings: Rings, style: Style) -> RingShapes:
    around = points.take(rings.around, axis=0)
    centre = around.mean(axis=1)
    offsets = around - centre[:, None]
    size = np.sqrt(np.einsum("rki,rki->r", offsets, offsets) / offsets.shape[1])
    offsets /= np.maximum(size, _TINY)[:, None, None]
    following = np.roll(offsets, -1, axis=1)
    area = 0.5 * _cross(offsets, following).sum(axis=1)
    extent = np.sqrt(np.einsum("ri,ri->r", area, area))
    distance = np.sqrt(np.einsum("rki,rki->rk", offsets, offsets))
    step = following - offsets
    normal = area / np.maximum(extent, _TINY)[:, None]
    leading = _rolled(offsets, distance.argmax(axis=1))
    axes = frames(leading, normal)
    turning = _Turning.of(np.einsum("rki,rji->rkj", leading, axes), np.maximum(extent, _TINY))
    spread = turning.spread(style)
    out = (points.take(rings.vertex, axis=0) - centre) / np.maximum(size, _TINY)[:, None]
    return RingShapes(
        points=points,
        around=rings.around,
        centre=centre,
        size=size,
        normal=normal,
        distance=distance,
        chord=np.sqrt(np.einsum("rki,rki->rk", step, step)),
        spread=spread,
        sway=turning.sway,
        swing=turning.swing(np.einsum("rij,rj->ri", axes, out)) / spread,
        style=style,
    )


def in_style(shapes: RingShapes, style: Style) -> RingShapes:
    """Return the same shapes for marks of another style."""
    if style is shapes.style:
        return shapes
    found = replace(shapes, style=style)
    spread = spreads_from(found, shapes.distance.argmax(axis=1))
    return replace(found, spread=spread, swing=shapes.swing * shapes.spread / spread)


def spreads_from(shapes: RingShapes, start: IntArray) -> FloatArray:
    """Return the spreads (r,) that the rings have where neighbour `start` (r,) leads."""
    spreads = np.empty(len(start))
    for rows in blocks(len(start), _BLOCK):
        offsets = shapes.offsets(rows)
        area = 0.5 * _cross(offsets, np.roll(offsets, -1, axis=1)).sum(axis=1)
        extent = np.maximum(np.sqrt(np.einsum("ri,ri->r", area, area)), _TINY)
        leading = _rolled(offsets, start[rows])
        local = np.einsum("rki,rji->rkj", leading, frames(leading, shapes.normal[rows]))
        spreads[rows] = _Turning.of(local, extent).spread(shapes.style)
    return spreads


@dataclass(frozen=True, eq=False, kw_only=True)
class _Turning:
    """How errors of standard deviation 1 of all neighbours, in ring sizes, turn the frames of r rings of k.

    count: k. second: (r, 3, 3) second moments of the neighbours in their frame. tilt: (r, 3, 3) covariance of the
    normal's error; twist: (r,) variance of how far the first axis turns around it.
    """

    count: int
    second: FloatArray
    tilt: FloatArray
    twist: FloatArray

    @classmethod
    def of(cls, local: FloatArray, area: FloatArray) -> _Turning:
        """Return that of offsets `local` (r, k, 3) in their frames; area: (r,) of the rings, above 0.

        Errors tilt the normal by that of the area vector, half the sum of error x (next - previous neighbour); they
        turn the first axis by that of the harmonic.
        """
        across = np.roll(local, -1, axis=1) - np.roll(local, 1, axis=1)
        chords = np.einsum("rki,rkj->rij", across, across)
        whole = np.einsum("rii->r", chords)
        wave = _wave(local.shape[1])
        harmonic = np.einsum("rki,k->ri", local, wave)
        return cls(
            count=local.shape[1],
            second=np.einsum("rki,rkj->rij", local, local),
            tilt=(whole[:, None, None] * np.eye(3) - chords) / (4.0 * area**2)[:, None, None],
            twist=(wave @ wave) / np.maximum(harmonic[:, 0] ** 2, _TINY),
        )

    @property
    def sway(self) -> FloatArray:
        """Return (r,): how far the frame turns in all."""
        return np.asarray(np.sqrt(self.tilt[:, 0, 0] + self.tilt[:, 1, 1] + self.twist))

    def spread(self, style: Style) -> FloatArray:
        """Return (r,): how much errors grow in the place of a mark, to first order, on the axis where most.

        The place in the ring is the point less a sum of the neighbours with weights +-1, turned into the frame and
        scaled. The sum over random signs has the second moments of the offsets. Without pull the sum is the mean,
        which turns with nothing: only the point turns, `_LIFT` from it.
        """
        if not style.pull:
            return np.asarray(np.sqrt(1.0 + 1.0 / self.count + (_LIFT * self.sway) ** 2))
        return np.asarray(np.sqrt(1.2 + self.count + self._moved(self.second)))

    def swing(self, place: FloatArray) -> FloatArray:
        """Return (r,): how far the frame moves points at places (r, 3) in it, on the axis where most."""
        return np.asarray(np.sqrt(self._moved(place[:, :, None] * place[:, None, :])))

    def _moved(self, second: FloatArray) -> FloatArray:
        """Return variances (r,) of what has second moments (r, 3, 3), as errors turn and scale the frame."""
        x, y, n = second[:, 0, 0], second[:, 1, 1], second[:, 2, 2]
        moved = [
            x / self.count + y * self.twist + n * self.tilt[:, 0, 0],
            y / self.count + x * self.twist + n * self.tilt[:, 1, 1],
            n / self.count + np.einsum("rij,rij->r", second[:, :2, :2], self.tilt[:, :2, :2]),
        ]
        return np.asarray(np.max(moved, axis=0))


def starts(distance: FloatArray, tolerance: FloatArray) -> tuple[IntArray, IntArray]:
    """Return (row, neighbour), each (c,): the neighbours within `tolerance` (r,) of the farthest of each ring."""
    row, neighbour = np.nonzero(distance >= (distance.max(axis=1) - tolerance)[:, None])
    return row, neighbour


def frames(offsets: FloatArray, normal: FloatArray) -> FloatArray:
    """Return (r, 3, 3): for each ring its axes as rows, the last the normal, the first towards its first neighbour.

    More exactly towards the first harmonic of the offsets (r, k, 3), which all neighbours hold in place. Zeros
    where there is none.
    """
    mode = np.einsum("rki,k->ri", offsets, _wave(offsets.shape[1]))
    mode -= np.einsum("ri,ri->r", mode, normal)[:, None] * normal
    mode /= np.maximum(np.sqrt(np.einsum("ri,ri->r", mode, mode)), _TINY)[:, None]
    return np.stack([mode, _cross(normal, mode), normal], axis=1)


def _wave(count: int) -> FloatArray:
    return np.asarray(np.cos(2.0 * np.pi * np.arange(count) / count))


def _rolled(values: NDArray[np.float64], start: IntArray) -> FloatArray:
    """Return `values` (r, k, ...) with neighbour `start` (r,) of each ring leading."""
    count = values.shape[1]
    order = (start[:, None] + np.arange(count)) % count
    return np.asarray(values[np.arange(len(values))[:, None], order])


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    out = np.empty(a.shape)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return out
