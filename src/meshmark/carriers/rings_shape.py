"""Where a point lies in the frame of its ring, and how firmly the ring holds that frame.

All is invariant to similarity transforms and to the order of points and faces (DESIGN section 7). The ring alone
makes the frame: a ring that stays, while its middle point moves, gives the same frame again.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from meshmark.carriers.rings import Rings
from meshmark.mesh import FloatArray, IntArray

__all__ = ["RingShapes", "frames", "ring_shapes", "starts"]

_TINY = 1e-30


@dataclass(frozen=True, eq=False)
class RingShapes:
    """Shapes of r rings of k neighbours.

    centre: (r, 3) mean of the neighbours. size: (r,) their RMS distance from it, in scene units; 0 where they
    coincide. offsets: (r, k, 3) the neighbours less the centre, in units of the size. normal: (r, 3) unit, of the
    polygon's area vector; zeros where it has none. distance: (r, k) lengths of the offsets. chord: (r, k) from each
    neighbour to the next. spread: (r,) how much an error of one coordinate of every neighbour and of the middle point
    grows in the point's place in the ring, a factor of standard deviations.
    """

    centre: FloatArray
    size: FloatArray
    offsets: FloatArray
    normal: FloatArray
    distance: FloatArray
    chord: FloatArray
    spread: FloatArray

    def take(self, rows: IntArray | NDArray[np.bool_]) -> RingShapes:
        """Return these rows."""
        return RingShapes(*(getattr(self, field.name)[rows] for field in fields(self)))


def ring_shapes(points: FloatArray, rings: Rings) -> RingShapes:
    """Return the shapes of rings, of points (p, 3)."""
    around = points[rings.around]
    centre = around.mean(axis=1)
    offsets = around - centre[:, None]
    size = np.sqrt(np.einsum("rki,rki->r", offsets, offsets) / offsets.shape[1])
    offsets /= np.maximum(size, _TINY)[:, None, None]
    following = np.roll(offsets, -1, axis=1)
    area = 0.5 * _cross(offsets, following).sum(axis=1)
    extent = np.sqrt(np.einsum("ri,ri->r", area, area))
    distance = np.sqrt(np.einsum("rki,rki->rk", offsets, offsets))
    step = following - offsets
    across = following - np.roll(offsets, 1, axis=1)
    count = offsets.shape[1]
    tilt = np.einsum("rki,rki->r", across, across) / (8.0 * np.maximum(extent, _TINY) ** 2)
    wave = _wave(count)
    mode = np.einsum("rki,k->ri", _rolled(offsets, distance.argmax(axis=1)), wave)
    twist = (wave @ wave) / np.maximum(np.einsum("ri,ri->r", mode, mode), _TINY)
    spread = np.sqrt(1.5 + count + count * (2.0 * tilt + 2.0 * twist + 1.0 / count) / 3.0)
    return RingShapes(
        centre,
        size,
        offsets,
        area / np.maximum(extent, _TINY)[:, None],
        distance,
        np.sqrt(np.einsum("rki,rki->rk", step, step)),
        spread,
    )


def starts(distance: FloatArray, tolerance: FloatArray) -> tuple[IntArray, IntArray]:
    """Return (row, neighbour), each (c,): the farthest neighbours of each ring, and those within `tolerance` (r,)."""
    row, neighbour = np.nonzero(distance >= (distance.max(axis=1) - tolerance)[:, None])
    return row, neighbour


def frames(offsets: FloatArray, normal: FloatArray) -> FloatArray:
    """Return (r, 3, 3): for each ring its axes as rows, the last the normal, the first towards its first neighbour.

    More exactly towards the first harmonic of the offsets (r, k, 3), which all neighbours hold in place. Zeros where
    there is none.
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
