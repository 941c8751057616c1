"""The roundings that a tolerance promises to bear, and whether a marked model does.

Each but the turned one is the same function of a file whoever applies it: what is borne here is borne always.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.examination import examine
from meshmark.coding.keys import Key
from meshmark.geometry.surface_of import surface_of_moved
from meshmark.marking.verification import authentic
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.scene.distinct import as_shown

__all__ = ["ROUNDINGS", "Broken", "broken_by", "rounded_by"]

Rounding = Callable[[FloatArray], FloatArray]
# What changes no coordinate by more than this share of what the marks are made for is not tried.
_HARMLESS: Final = 0.2
# Powers of ten up to this are exact in a double, and six decimals of a number below the other are a whole number.
_EXACT: Final = 22
_LARGEST: Final = 1e6


def _turned(vertices: FloatArray) -> FloatArray:
    """Turn, scale and move as 32-bit floats can hold it worst: small, and far from the origin."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec([0.7, -1.9, 1.1]).as_matrix()
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    small = (vertices - vertices.min(axis=0)) @ turn.T * 0.15
    return _floats(small + diagonal * np.array([0.9, -0.8, 0.7]))


def _floats(vertices: FloatArray) -> FloatArray:
    """Round to 32-bit floats, but for what is beyond them."""
    with np.errstate(over="ignore"):
        rounded = vertices.astype(np.float32).astype(np.float64)
    return np.where(np.isfinite(rounded), rounded, vertices)


def _decimals(vertices: FloatArray) -> FloatArray:
    return _written("%.6f", vertices, np.full(vertices.shape, 6))


def _digits(vertices: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore"):
        before = np.floor(np.log10(np.abs(vertices)))
    return _written("%.6g", vertices, np.where(np.isfinite(before), 5.0 - before, 0.0).astype(np.int64))


def _written(style: str, vertices: FloatArray, places: IntArray) -> FloatArray:
    """Return what is read of numbers that were written in a style, which has these `places` after the point.

    A whole number over a power of ten, where both are exact, is the double nearest to the decimal number, as a
    reader has it, in a tenth of the time. Of numbers half-way between two decimal ones either may come.
    """
    exact = (np.abs(places) <= _EXACT) & (np.abs(vertices) < _LARGEST)
    unit = 10.0 ** np.where(exact, np.abs(places), 0)
    many = places >= 0
    whole = np.rint(np.where(many, vertices * unit, vertices / unit))
    rounded = np.where(many, whole / unit, whole * unit)
    if not exact.all():
        rounded[~exact] = np.char.mod(style, vertices[~exact]).astype(np.float64)
    return np.asarray(rounded)


def _on_grid(vertices: FloatArray, size: FloatArray, steps: float) -> FloatArray:
    low = vertices.min(axis=0)
    step = size / steps
    index = np.rint((vertices - low) / np.where(step == 0.0, 1.0, step))
    return np.where(step == 0.0, vertices, low + index * step)


def _grid_of_axes(vertices: FloatArray) -> FloatArray:
    return _on_grid(vertices, np.ptp(vertices, axis=0), 2.0**16 - 1.0)


def _grid_of_side(vertices: FloatArray) -> FloatArray:
    side = np.ptp(vertices, axis=0).max()
    return _on_grid(vertices, np.full(3, side), 2.0**16 - 1.0)


def _grid_of_cells(vertices: FloatArray) -> FloatArray:
    return _on_grid(vertices, np.ptp(vertices, axis=0), 2.0**16)


def _packed(vertices: FloatArray) -> FloatArray:
    """Round as gltfpack and Draco do with 14 bits: whole steps from the least corner, the longest side has all."""
    return _on_grid(vertices, np.full(3, np.ptp(vertices, axis=0).max()), 2.0**14 - 1.0)


def _halves(vertices: FloatArray) -> FloatArray:
    """Round as glTF-Transform does with 14 bits: a sign and 13 bits from the middle, stretched to 16 bits."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle, half = (low + high) / 2.0, float((high - low).max()) / 2.0
    if half == 0.0:
        return vertices
    share = (vertices - middle) / half
    whole = np.rint(np.abs(share) * (2**13 - 1)).astype(np.int64)
    stored = (whole << 2) | (whole >> 11)
    return np.asarray(middle + half * np.sign(share) * stored / (2.0**15 - 1.0))


ROUNDINGS: Final[dict[str, tuple[Rounding, str]]] = {
    "turned": (_turned, "turning, scaling and moving in 32-bit floats"),
    "floats": (_floats, "32-bit floats"),
    "decimals": (_decimals, "an export with six decimals"),
    "digits": (_digits, "an export with six significant digits"),
    "axes": (_grid_of_axes, "a grid of 16 bits on each axis"),
    "cells": (_grid_of_cells, "a grid of 16 bits on each axis"),
    "side": (_grid_of_side, "a grid of 16 bits on the longest side"),
    "packed": (_packed, "a grid of 14 bits as gltfpack and Draco choose it"),
    "halves": (_halves, "a grid of 14 bits as glTF-Transform chooses it"),
}
"""Name of a rounding: what it does to vertices (n, 3), and what it is called."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Broken:
    """called: the rounding after which a mesh is not authentic; unread: (p,) the points without a mark then, all
    that are altered where there is no such point; passed: (p,) whose marks hold then.
    """

    called: str
    unread: NDArray[np.bool_]
    passed: NDArray[np.bool_]


def rounded_by(vertices: FloatArray, bears: Iterable[str], error: float) -> Iterator[tuple[str, FloatArray]]:
    """Yield what each of `ROUNDINGS`, of those named, is called, and vertices (n, 3) that are rounded so.

    Those that change most come first, those that change next to nothing do not. error: of a coordinate, that the
    marks are made for, in scene units.
    """
    changes: list[tuple[float, str]] = []
    for name in bears:
        change = error if name == "turned" else float(np.abs(ROUNDINGS[name][0](vertices) - vertices).max())
        if name == "turned" or change > _HARMLESS * error:
            changes.append((change, name))
    for _, name in sorted(changes, key=lambda each: -each[0]):
        rounding, called = ROUNDINGS[name]
        yield called, rounding(vertices)  # anew: all of them at once would take gigabytes of a large model


def broken_by(mesh: Mesh, key: Key, identity: int, bears: Iterable[str], error: float) -> Broken | None:
    """Return one of `ROUNDINGS`, of those named, after which a mesh is not authentic (see `rounded_by`).

    None where the marks bear them all.
    """
    for called, vertices in rounded_by(mesh.vertices, bears, error):
        again = mesh.with_vertices(vertices)
        surface_of_moved(again, mesh)  # remembered, so that `examine` need not weld it
        found = examine(as_shown(again), key, made=identity)
        if not authentic(found, identity):
            unread = found.altered & found.checks.eligible & ~found.checks.verified
            unread = unread if unread.any() else found.altered
            return Broken(called=called, unread=unread, passed=found.checks.passed)
    return None
