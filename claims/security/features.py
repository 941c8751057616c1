"""Numbers of a mesh that a mark might change: how points lie among their neighbours, and energies in bands."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from meshmark.geometry.areas import vertex_areas_and_normals
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.parameters import preferred_spacings

__all__ = ["calibrated_features", "plain_features"]

QUANTILES = (0.05, 0.1, 0.25, 0.5, 0.75, 0.9)
# Widths of the bands, in spacings of the lattice that a mark would have.
WIDTHS = (0.06, 0.12, 0.2, 0.3, 0.45, 0.7)
DIFFERENCES = 4
MOST_STEPS = 900
TINY = 1e-12
# Steps of a walk after which a model is as good as unmarked.
CALIBRATION = 3


def plain_features(mesh: Mesh) -> FloatArray:
    """Return logarithms of the statistics (d,) of a mesh, as its file in 32 bits holds it."""
    surface = surface_of(mesh)
    points = surface.frame.to_canonical(surface.points.astype(np.float32).astype(np.float64))
    spacing = preferred_spacings(surface.frame.area)[0]
    return _features(points, surface.faces, surface.edges, surface.walk, spacing)


def calibrated_features(mesh: Mesh) -> FloatArray:
    """Return the same, and what they lose where the surface is smoothed a little, which takes a mark off."""
    surface = surface_of(mesh)
    points = surface.frame.to_canonical(surface.points.astype(np.float32).astype(np.float64))
    spacing = preferred_spacings(surface.frame.area)[0]
    smooth = _walked(surface.walk, points, CALIBRATION)
    given = (surface.faces, surface.edges, surface.walk, spacing)
    found = _features(points, *given)
    return np.concatenate([found, found - _features(smooth, *given)])


def _features(
    points: FloatArray, faces: np.ndarray, edges: np.ndarray, walk: csr_array, spacing: float
) -> FloatArray:
    areas, normals = vertex_areas_and_normals(points, faces)
    length = float(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1).mean())
    size = np.sqrt(np.maximum(areas, TINY))
    apart = points - walk @ points
    across = np.einsum("ij,ij->i", apart, normals)
    along = np.linalg.norm(apart - across[:, None] * normals, axis=1)
    found = [np.log(np.quantile(each / size, QUANTILES) + 1e-9) for each in (np.abs(across), along)]
    found.append(_of_differences(across, walk))
    bands = _bands(points, normals, walk, spacing / length)
    share = areas / areas.sum()
    found.append(np.log([np.sqrt(share @ band**2) / spacing + 1e-9 for band in bands]))
    for quantile in (0.1, 0.5):
        found.append(np.log([np.quantile(np.abs(band), quantile) / spacing + 1e-9 for band in bands]))
    for band in bands[2:5]:
        local = _walked(walk, band**2, max(3, _steps(0.4, spacing / length)))
        found.append(np.log([np.quantile(local, 0.9) / (np.quantile(local, 0.1) + TINY**2) + 1e-9]))
    return np.concatenate(found)


def _of_differences(values: FloatArray, walk: csr_array) -> FloatArray:
    """Return of repeated differences to the neighbours: correlation among these, kurtosis, energy."""
    whole = (values**2).mean() + TINY**2
    found = []
    for _ in range(DIFFERENCES):
        values = values - walk @ values
        energy = (values**2).mean() + TINY**2
        found += [
            (values * (walk @ values)).mean() / energy,
            np.log((values**4).mean() / energy**2 + 1e-9),
            0.5 * np.log(energy / whole),
        ]
    return np.array(found)


def _bands(points: FloatArray, normals: FloatArray, walk: csr_array, edges: float) -> list[FloatArray]:
    """Return what smoothing by each width takes off along the normals; edges: spacing over edge length."""
    found, done, last, smooth = [], 0, points, points
    for width in WIDTHS:
        steps = _steps(width, edges)
        smooth = _walked(walk, smooth, steps - done)
        found.append(np.einsum("ij,ij->i", last - smooth, normals))
        done, last = max(steps, done), smooth
    return found


def _steps(width: float, edges: float) -> int:
    """Return the steps of a lazy walk that spread by a width: edge length times the root of half of them."""
    return min(max(1, int(2.0 * (width * edges) ** 2)), MOST_STEPS)


def _walked(walk: csr_array, values: FloatArray, steps: int) -> FloatArray:
    for _ in range(steps):
        values = 0.5 * values + 0.5 * (walk @ values)
    return values
