"""Frames that a surface had before a part of it was cut off by a plane.

What is gone is unknown but for its border, yet of all its shape only ten numbers matter to the frame: its area, its
centroid and its second moments. A cap is drawn over the border, higher or lower, wider or narrower, leaning to a
side: frames of many such caps are thinned to a few that lie close to all, those first that stand for most.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.cut import Cut, find_cut
from meshmark.geometry.frame import Frame, signed_axes
from meshmark.geometry.raw_moments import RawMoments, raw_moments
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Completed", "completed_frames", "frame_distance"]

# Caps drawn. Of them, heights over the radius of the cut (evenly in the logarithm), and standard deviations of the
# logarithm of the area, of the centroid's height, of the second moments.
CAPS = 6000
LOWEST, HIGHEST = 0.12, 6.0
AREA, HEIGHT, MOMENT = 0.35, 0.15, 0.35
# Standard deviation of the centroid to a side, over height and over radius.
LEAN, LEAN_RADIUS = 0.25, 0.1
# Share of its height times border that a cap's sides have, and where its floor's area ends up.
SIDE, TOP = 0.6, 0.8
# A cap of more area than what is left is not guessed at.
LARGEST = 1.0
# The turn of axes counts by how far it moves the surface: two thirds of the squared angle.
TURN = 0.67
# This many times the number of frames asked for are ranked.
RANKED = 8


@dataclass(frozen=True, eq=False, kw_only=True)
class _Caps:
    """n caps: area (n,), centroid (n, 3), covariance (n, 3, 3)."""

    area: FloatArray
    centre: FloatArray
    spread: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class _Frames:
    """n frames: centre (n, 3), scale (n,), axes (n, 3, 3), moments (n, 3), area (n,), skewness (n, 3)."""

    centre: FloatArray
    scale: FloatArray
    axes: FloatArray
    moments: FloatArray
    area: FloatArray
    skewness: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Completed:
    """A cap over the cut of a surface, and the frame of the surface together with it.

    area: of the cap; places: (6, 3) with its centroid and its covariance, each for a sixth of its area.
    """

    frame: Frame
    area: float
    places: FloatArray


def completed_frames(points: FloatArray, faces: IntArray, apart: float, most: int) -> list[Completed]:
    """Return up to `most` caps with their frames, likeliest first, none where the surface has no planar cut.

    apart: how far these frames are from each other at least, as `frame_distance`.
    """
    cut = find_cut(points, faces)
    if cut is None:
        return []
    left = raw_moments(points, faces)
    caps = _draw(cut, left.area * LARGEST)
    frames = _frames(left, caps)
    kept = _thinned(frames, apart, most)
    return [
        Completed(frame=_frame(frames, i), area=float(caps.area[i]), places=_places(caps, i)) for i in kept
    ]


def frame_distance(one: Frame, other: Frame) -> float:
    """Return by how much one frame differs from the other, in RMS motion of the surface over its scale."""
    shift = float(((one.centre - other.centre) ** 2).sum()) / other.scale**2
    turn = 3.0 - float((one.axes * other.axes).sum())  # angle squared, for small ones
    return float(np.sqrt(shift + np.log(one.scale / other.scale) ** 2 + TURN * max(turn, 0.0)))


def _draw(cut: Cut, largest: float) -> _Caps:
    rng = np.random.default_rng(0)  # the same caps every time
    side = np.linalg.svd(cut.normal[None])[2][1:]
    height = cut.radius * np.exp(rng.uniform(np.log(LOWEST), np.log(HIGHEST), CAPS))
    wall = SIDE * cut.length * height
    area = (cut.area + wall) * np.exp(AREA * rng.normal(size=CAPS))
    up = (0.5 * wall + TOP * cut.area) * height / (cut.area + wall) * np.exp(HEIGHT * rng.normal(size=CAPS))
    lean = LEAN * height + LEAN_RADIUS * cut.radius
    centre = cut.centre + up[:, None] * cut.normal + lean[:, None] * (rng.normal(size=(CAPS, 2)) @ side)
    spread = _spreads(cut, height, lean, side, rng)
    kept = area < largest
    return _Caps(area=area[kept], centre=centre[kept], spread=spread[kept])


def _spreads(
    cut: Cut, height: FloatArray, lean: FloatArray, side: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Return (n, 3, 3): that of a dome over the border, and what it may differ by."""
    wide = 0.55 * np.exp(MOMENT * rng.normal(size=CAPS))
    tall = height**2 / 12.0 * np.exp(MOMENT * rng.normal(size=CAPS))
    normal = cut.normal
    spread = wide[:, None, None] * cut.spread + tall[:, None, None] * np.outer(normal, normal)
    one, other = side
    ways = np.stack([np.outer(one, one), np.outer(other, other), np.outer(one, other) + np.outer(other, one)])
    ways[2] *= 0.7
    spread += np.einsum("na,aij->nij", 0.1 * np.trace(cut.spread) * rng.normal(size=(CAPS, 3)), ways)
    tilt = (0.3 * lean * height)[:, None] * (rng.normal(size=(CAPS, 2)) @ side)
    slant = tilt[:, :, None] * normal
    return np.asarray(spread + slant + slant.transpose(0, 2, 1))


def _frames(left: RawMoments, caps: _Caps) -> _Frames:
    """Return the canonical frame of what is left together with each cap (see `geometry.frame.canonical_frame`)."""
    c, spread = caps.centre, caps.spread
    area = left.area + caps.area
    centre = (left.first + caps.area[:, None] * c) / area[:, None]
    second = left.second + caps.area[:, None, None] * (spread + c[:, :, None] * c[:, None, :])
    second /= area[:, None, None]
    values, axes = np.linalg.eigh(second - centre[:, :, None] * centre[:, None, :])
    values, axes = values[:, ::-1], axes[:, :, ::-1]
    scale = np.sqrt(values.sum(axis=1))
    mixed = c[:, :, None, None] * spread[:, None]
    third = c[:, :, None, None] * c[:, None, :, None] * c[:, None, None, :]
    third = third + mixed + mixed.transpose(0, 2, 1, 3) + mixed.transpose(0, 2, 3, 1)
    third = (left.third + caps.area[:, None, None, None] * third) / area[:, None, None, None]
    mean = np.einsum("ni,nia->na", centre, axes)
    square = np.einsum("nij,nia,nja->na", second, axes, axes, optimize=True)
    cube = np.einsum("nijk,nia,nja,nka->na", third, axes, axes, axes, optimize=True)
    cube = cube - 3.0 * mean * square + 2.0 * mean**3
    axes = signed_axes(axes, cube)
    skewness = np.abs(cube) / np.maximum(values, 1e-12 * scale[:, None] ** 2) ** 1.5
    return _Frames(
        centre=centre,
        scale=scale,
        axes=axes,
        moments=values / scale[:, None] ** 2,
        area=area / scale**2,
        skewness=skewness,
    )


def _frame(frames: _Frames, i: int) -> Frame:
    return Frame(
        centre=frames.centre[i],
        scale=float(frames.scale[i]),
        axes=np.ascontiguousarray(frames.axes[i]),
        moments=frames.moments[i],
        area=float(frames.area[i]),
        skewness=frames.skewness[i],
    )


def _places(caps: _Caps, i: int) -> FloatArray:
    """Return (6, 3): two along each principal axis of a cap, with its centroid and its covariance."""
    values, axes = np.linalg.eigh(caps.spread[i])
    ways = (axes * np.sqrt(3.0 * np.maximum(values, 0.0))).T
    return np.asarray(caps.centre[i] + np.concatenate([ways, -ways]))


def _thinned(frames: _Frames, apart: float, most: int) -> IntArray:
    """Return frames at least so far from each other that stand for the most others, those first."""
    left = np.flatnonzero(frames.moments[:, -1] >= 0.0)  # others are of caps that no surface has
    kept: list[tuple[int, int]] = []
    # Dense places are met early: after many kept, the next would stand for few.
    while len(left) and len(kept) < RANKED * most:
        i = int(left[0])
        shift = ((frames.centre[left] - frames.centre[i]) ** 2).sum(axis=1) / frames.scale[i] ** 2
        turn = np.maximum(3.0 - frames.axes[left].reshape(-1, 9) @ frames.axes[i].ravel(), 0.0)
        away = shift + np.log(frames.scale[left] / frames.scale[i]) ** 2 + TURN * turn >= apart**2
        away[0] = False
        kept.append((int(away.sum()) - len(left), i))
        left = left[away]
    return np.array([i for _, i in sorted(kept)[:most]], dtype=np.int64)
