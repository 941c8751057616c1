"""How far a model's coordinates may be off after benign operations, and so how fine its marks can be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.parameters import FAR_AWAY, FINE, WEB, WEB_GRID, Style
from meshmark.errors import InputError
from meshmark.geometry.extent import used_points
from meshmark.io.file_precision import conform
from meshmark.mesh import FloatArray, Mesh
from meshmark.scene.distinct import scene_of

__all__ = ["TOLERANCES", "Precision", "precision_of", "precisions_of"]

TOLERANCES = ("strict", "default", "tolerant", "web")
# Half the last digit of an export with six decimals.
_DECIMALS = 0.5e-6
# Half the last place of 32-bit floats, relative.
_FLOAT32 = 2.0**-24
# Half the step of a grid of 16 bits, over the longest side.
_GRID = 2.0**-17
# Rounding to six significant digits may be this number of times what a step is made for, at this share of the
# vertices: half a step is 5.7 deviations of the error, and in rounded files a mark is found up to a whole step off.
_FELT, _MOST = 2.0, 0.95

_NOT_SIX = "an export with six significant digits is called altered: --tolerance tolerant bears it"
# Names of the roundings that are borne (`promises.ROUNDINGS`).
_FLOATS = ("turned", "floats")
_STRICT = (*_FLOATS, "decimals")
_DEFAULT = (*_STRICT, "digits")
_TOLERANT = (*_DEFAULT, "axes", "cells", "side")
_WEB = ("floats", "decimals", "digits", "packed", "halves")
_BEARS = {"strict": _STRICT, "tolerant": _TOLERANT, "web": _WEB}


@dataclass(frozen=True, kw_only=True)
class Precision:
    """error: the largest of a coordinate, in scene units, that must not break a mark; enough: payload bits per
    vertex that it must leave room for, to be chosen; remark: what is given up with it. bears: names of the
    `promises.ROUNDINGS` that a model with such marks is promised to bear. style: how the marks are made.
    """

    error: float
    style: Style = FINE
    enough: float = 0.0
    remark: str | None = None
    bears: tuple[str, ...] = ()


def precisions_of(mesh: Mesh, tolerance: str | None = None) -> tuple[Precision, ...]:
    """Return what may be chosen for a model, coarsest first.

    None or "default": what the model's own file, six decimals, floats of 32 bits after a similarity transform, and
    an export with six significant digits round; the last of these where it costs no needed payload, decimals and
    the distance from the origin where there is room. Raises `InputError` for an unknown tolerance.
    """
    if tolerance is not None and tolerance != "default":
        error = precision_of(mesh, tolerance)
        return (Precision(error=error, bears=_BEARS[tolerance], style=WEB if tolerance == "web" else FINE),)
    strict, floats = precision_of(mesh), _floats(mesh)
    digits = _six_digits(mesh)
    chosen = [
        Precision(error=max(digits, strict), enough=float(digits > strict), bears=_DEFAULT),
        Precision(error=strict, remark=_NOT_SIX, bears=_STRICT),
    ]
    if floats < strict:
        remark = "the model is so small that the marks of authentication need more than six decimals"
        remark = f"{remark}: in exports with fewer it is called altered"
        chosen.append(Precision(error=floats, remark=remark, bears=_FLOATS))
    if (near := _near(mesh)) < floats:
        remark = (
            "the model lies so far from its origin that the marks of authentication need double precision"
        )
        chosen.append(Precision(error=near, remark=f"{remark}: in exports with less it is called altered"))
    return tuple(chosen)


def precision_of(mesh: Mesh, tolerance: str = "strict") -> float:
    """Return the largest error of a coordinate, in scene units, that must not break a mark.

    "strict": what the mesh's own file, an export with six decimals, and 32-bit floats after a similarity transform
    round; "default" no less; "tolerant": also an export with six significant digits or on a grid of 16 bits; "web":
    also on one of 14 bits.
    Raises `InputError` for an unknown tolerance.
    """
    if tolerance not in TOLERANCES:
        raise InputError(f"unknown tolerance '{tolerance}', expected one of {', '.join(TOLERANCES)}")
    strict = max(_DECIMALS / _smallest(mesh), _floats(mesh))
    if tolerance not in ("tolerant", "web"):
        return strict
    scene = _scene(mesh)
    digits = 0.5 * 10.0 ** (np.ceil(np.log10(float(np.abs(_used(scene)).max()))) - 6.0)
    grid = (WEB_GRID if tolerance == "web" else _GRID) * float(np.ptp(scene.vertices, axis=0).max())
    return max(strict, float(digits) / _smallest(mesh), grid / _smallest(mesh))


def _scene(mesh: Mesh) -> Mesh:
    """Return the whole scene of a mesh that stands for its copies, any other mesh itself."""
    found = scene_of(mesh)
    return mesh if found is None else found.scene


def _smallest(mesh: Mesh) -> float:
    """Return how large the smallest copy of a mesh is beside it: rounding weighs more there; 1 without copies."""
    found = scene_of(mesh)
    return 1.0 if found is None else found.smallest


def _used(mesh: Mesh) -> FloatArray:
    """Return the vertices that faces use, all where none does: where the others lie says nothing of the surface."""
    return np.asarray(mesh.vertices[_are_used(mesh)])


def _are_used(mesh: Mesh) -> NDArray[np.bool_]:
    """Return (v,): the vertices that faces use, all where none does."""
    count = len(mesh.vertices)
    return used_points(mesh.faces, count) if len(mesh.faces) else np.ones(count, bool)


def _floats(mesh: Mesh) -> float:
    """Return what the mesh's own file, and 32-bit floats after a similarity transform, round."""
    used = _used(_scene(mesh))
    diagonal = float(np.linalg.norm(np.ptp(used, axis=0)))
    farthest = float(np.abs(used).max())
    return max(_near(mesh), 2.0 * _FLOAT32 * (farthest + diagonal) / _smallest(mesh))


def _near(mesh: Mesh) -> float:
    """Return what the mesh's own file, and 32-bit floats of a model at the origin, round."""
    extent = np.ptp(_used(mesh), axis=0)
    return max(FAR_AWAY * float(np.linalg.norm(extent)), _own(mesh, float(extent.max())))


def _six_digits(mesh: Mesh) -> float:
    """Return what six significant digits round, as an error of all coordinates alike that marks feel as much."""
    size = np.maximum(np.abs(_used(_scene(mesh))), np.finfo(float).tiny)
    half = 0.5 * 10.0 ** (np.floor(np.log10(size)) - 5.0)
    felt = np.sqrt((half**2).mean(axis=1))
    return float(np.quantile(felt, _MOST)) / _FELT / _smallest(mesh)


def _own(mesh: Mesh, size: float) -> float:
    """Return how far the mesh's file moves coordinates of the surface that it is given."""
    nudged = mesh.vertices + size * 1e-4 * np.sin(np.arange(mesh.vertices.size)).reshape(-1, 3)
    off = np.abs(conform(mesh, nudged) - nudged)
    return float(off[_are_used(mesh)].max())
