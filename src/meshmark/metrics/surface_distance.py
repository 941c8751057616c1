"""Distances between two surfaces, whatever their triangles (docs/design.md, section 11).

Each surface is sampled and each sample's exact distance to the other surface taken, as METRO does: P. Cignoni,
C. Rocchini, R. Scopigno, "Metro: measuring error on simplified surfaces", 1998, 10.1111/1467-8659.00236.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from meshmark.mesh import FloatArray, Mesh
from meshmark.metrics.displacement import diagonal
from meshmark.metrics.measured_surface import MeasuredSurface, surface_of
from meshmark.metrics.surface_samples import STEPS, sample_edges, sample_faces

__all__ = [
    "SurfaceDistances",
    "hausdorff_over_diagonal",
    "mrms_over_diagonal",
    "surface_distances",
    "symmetric_rms_over_diagonal",
]

SAMPLES = 32_000  # of the edges and as many of the faces: the RMS is then within 1 % of its limit
# The surface around the REFINED farthest samples is searched again at AROUND points each, ever more finely.
REFINED, AROUND, ROUNDS, SHRINK = 32, 24, 3, 0.3


@dataclass(frozen=True, kw_only=True)
class SurfaceDistances:
    """Distances from surface A to surface B (`ab`) and back (`ba`), in model units.

    rms: over edges and faces, half the weight each, as METRO's default samples have it.
    area_rms: over faces alone, the integral over the surface. hausdorff: the largest found.
    """

    rms_ab: float
    rms_ba: float
    area_rms_ab: float
    area_rms_ba: float
    hausdorff_ab: float
    hausdorff_ba: float


def surface_distances(a: Mesh, b: Mesh, samples: int | None = None) -> SurfaceDistances:
    """Measure both directions with this many samples of edges and of faces, and all vertices for the largest.

    samples: 32,000 by default.
    Loose vertices are no part of a surface. Raises `InputError` where a model has no surface or extent.
    """
    first, second = surface_of(a), surface_of(b)
    if first.equals(second):
        return SurfaceDistances(
            rms_ab=0.0, rms_ba=0.0, area_rms_ab=0.0, area_rms_ba=0.0, hausdorff_ab=0.0, hausdorff_ba=0.0
        )
    samples = samples or SAMPLES
    known = _KNOWN.setdefault(first, WeakKeyDictionary()).setdefault(second, {})
    if samples not in known:
        ab, ba = _one_way(first, second, samples), _one_way(second, first, samples)
        known[samples] = SurfaceDistances(
            rms_ab=ab[0],
            rms_ba=ba[0],
            area_rms_ab=ab[1],
            area_rms_ba=ba[1],
            hausdorff_ab=ab[2],
            hausdorff_ba=ba[2],
        )
    return known[samples]


# The measures below ask for the same distances one after the other.
_KNOWN: WeakKeyDictionary[
    MeasuredSurface, WeakKeyDictionary[MeasuredSurface, dict[int, SurfaceDistances]]
] = WeakKeyDictionary()


def mrms_over_diagonal(a: Mesh, b: Mesh) -> float:
    """Return the larger of both directions' RMS distances over the diagonal of `a`, 0 upwards.

    MRMS stands for maximum root mean square, as in the watermarking benchmark of Wang et al. 2010
    (10.1109/SMI.2010.33).
    """
    distances = surface_distances(a, b)
    return max(distances.rms_ab, distances.rms_ba) / diagonal(a)


def symmetric_rms_over_diagonal(a: Mesh, b: Mesh) -> float:
    """Return the mean of both directions' RMS distances over the diagonal of `a`, 0 upwards."""
    distances = surface_distances(a, b)
    return 0.5 * (distances.rms_ab + distances.rms_ba) / diagonal(a)


def hausdorff_over_diagonal(a: Mesh, b: Mesh) -> float:
    """Return the larger of both directions' largest distances over the diagonal of `a`, 0 upwards."""
    distances = surface_distances(a, b)
    return max(distances.hausdorff_ab, distances.hausdorff_ba) / diagonal(a)


def _one_way(start: MeasuredSurface, target: MeasuredSurface, samples: int) -> tuple[float, float, float]:
    """Return RMS, RMS over faces alone, and the largest distance."""
    unit = start.scaled(start.points)
    both = np.concatenate(
        [sample_faces(unit, start.faces, samples), sample_edges(unit, start.faces, samples)]
    )
    both = start.low + start.longest * both
    sampled = target.index.nearest(both).distances
    used = np.unique(start.faces)
    positions = np.concatenate([both, start.points[used]])
    distances = np.concatenate([sampled, start.nearest_on(target).distances[used]])
    spread = start.longest * np.sqrt(start.areas_and_normals[0].sum() / samples)
    return _rms(sampled), _rms(sampled[:samples]), _largest(start, target, positions, distances, spread)


def _rms(values: FloatArray) -> float:
    largest = float(values.max())
    return largest * float(np.sqrt(np.mean(np.square(values / largest)))) if largest else 0.0


def _largest(
    start: MeasuredSurface,
    target: MeasuredSurface,
    positions: FloatArray,
    distances: FloatArray,
    spread: float,
) -> float:
    """Return the largest distance, after a closer look at the surface around the farthest samples."""
    for _ in range(ROUNDS):
        top = np.argsort(distances)[-REFINED:]
        around = (positions[top][:, None] + spread * _ball()).reshape(-1, 3)
        around = start.index.nearest(around).points
        positions = np.concatenate([positions[top], around])
        distances = np.concatenate([distances[top], target.index.nearest(around).distances])
        spread *= SHRINK
    return float(distances.max())


def _ball() -> FloatArray:
    """Return (AROUND, 3) points spread through the unit ball."""
    number = np.arange(AROUND) + 0.5
    height = 1.0 - 2.0 * number / AROUND
    turn = number * np.pi * (3.0 - np.sqrt(5.0))
    flat = np.sqrt(1.0 - height**2)
    out = np.stack([flat * np.cos(turn), flat * np.sin(turn), height], axis=1)
    return np.asarray(out * np.cbrt(number * STEPS[0] % 1.0)[:, None])
