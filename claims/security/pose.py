"""Where a lattice lies, estimated from where a mark moved the surface: its energy peaks at the lattice's waves.

The displacement of a mark is strongest at the nodes of its lattice, so the spectrum of its energy has peaks at one
wave along each of the three axes, whose phases tell the shift.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from meshmark.geometry.areas import vertex_areas_and_normals
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, Mesh

__all__ = ["Energy", "Guess", "energy_alone", "energy_of_pair", "guessed", "off_by"]

MOST_PLACES = 2500
DIRECTIONS = 4000
PEAKS, STARTS, REFINEMENTS = 40, 4, 48
# A place counts at most so many times the mean.
CLIPPED = 5.0
# Bands of a marked model alone: what a walk smooths between these shares of a spacing, whitened over one spacing.
BAND, WHITENED, MOST_STEPS = (0.12, 0.35), 1.0, 400


@dataclass(frozen=True, eq=False, kw_only=True)
class Energy:
    """Where a model was moved: canonical places (n, 3), weights (n,) of mean 0, and the spacing of its lattice."""

    places: FloatArray
    weights: FloatArray
    spacing: float
    scale: float

    def waves(self, directions: FloatArray) -> np.ndarray:
        """Return the complex amplitudes (k,) of one wave a spacing along directions (k, 3), over their RMS."""
        return _waves(self.places, self.weights, directions / self.spacing) / self.scale


def _waves(places: FloatArray, weights: FloatArray, waves: FloatArray) -> np.ndarray:
    parts = [
        np.exp(-2j * np.pi * (waves[first : first + 400] @ places.T)) @ weights
        for first in range(0, len(waves), 400)
    ]
    return np.concatenate(parts)


def _energy(places: FloatArray, areas: FloatArray, moved: FloatArray, spacing: float) -> Energy:
    energy = moved * moved
    share = areas / areas.sum()
    energy = np.minimum(energy / max(share @ energy, np.finfo(float).tiny), CLIPPED)
    weights = share * (energy - share @ energy)
    rng = np.random.default_rng(0)
    taken = rng.permutation(len(places))[:MOST_PLACES]
    places, weights = places[taken], weights[taken]
    random = _unit(rng.normal(size=(300, 3)))
    scale = float(np.sqrt(np.mean(np.abs(_waves(places, weights, random / spacing)) ** 2)))
    return Energy(places=places, weights=weights, spacing=spacing, scale=scale)


def energy_of_pair(original: Mesh, marked: Mesh, spacing: float) -> Energy:
    """Return where a marked model was moved along its normals, known from the original."""
    surface = surface_of(marked)
    areas, normals = vertex_areas_and_normals(surface.points, surface.faces)
    before = original.vertices[surface.vertex_of_point]
    moved = np.einsum("ij,ij->i", surface.points - before, normals)
    return _energy(surface.frame.to_canonical(surface.points), areas, moved, spacing)


def energy_alone(marked: Mesh, spacing: float) -> Energy:
    """Return where a marked model departs from itself, smoothed, in the band of its bumps: all it tells alone."""
    surface = surface_of(marked)
    frame = surface.frame
    points, walk = frame.to_canonical(surface.points), surface.walk
    areas, normals = vertex_areas_and_normals(points, surface.faces)
    ends = points[surface.edges]
    length = float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean())
    steps = [min(max(1, int(2.0 * (share * spacing / length) ** 2)), MOST_STEPS) for share in BAND]
    fine = _walked(walk, points, steps[0])
    coarse = _walked(walk, fine, max(steps[1] - steps[0], 1))
    departs = np.einsum("ij,ij->i", fine - coarse, normals)
    around = _walked(walk, departs**2, min(max(3, int(2.0 * (WHITENED * spacing / length) ** 2)), MOST_STEPS))
    return _energy(points, areas, departs / np.sqrt(around + 1e-4 * around.mean()), spacing)


def _walked(walk: csr_array, values: FloatArray, steps: int) -> FloatArray:
    for _ in range(steps):
        values = 0.5 * values + 0.5 * (walk @ values)
    return values


@dataclass(frozen=True, eq=False, kw_only=True)
class Guess:
    """A pose: axes (3, 3) in rows, and the shift for each spacing of which there was evidence."""

    axes: FloatArray
    shifts: dict[float, FloatArray]

    def shift(self, spacing: float) -> FloatArray:
        """Return the shift (3,) of lattices of this spacing, 0 where nothing was learnt of them."""
        return self.shifts.get(round(spacing, 9), np.zeros(3))


def guessed(energies: Sequence[Energy], rng: np.random.Generator) -> Guess:
    """Return the pose at which the spectra of all models together are strongest, as if they had one lattice."""
    sphere = _sphere(DIRECTIONS)
    power = sum(np.abs(each.waves(sphere)) ** 2 for each in energies)

    def total(axes: FloatArray) -> float:
        return float(sum((np.abs(each.waves(axes)) ** 2).sum() for each in energies))

    best: tuple[float, FloatArray] | None = None
    for axes in _starts(sphere, power):
        value, size = total(axes), np.radians(1.5)
        for turn in range(REFINEMENTS):
            other = axes @ Rotation.from_rotvec(size * rng.normal(size=3)).as_matrix().T
            if (found := total(other)) > value:
                value, axes = found, other
            elif turn % 12 == 11:
                size *= 0.6
        if best is None or value > best[0]:
            best = value, axes
    assert best is not None
    sums: dict[float, np.ndarray] = {}
    for each in energies:
        name = round(each.spacing, 9)
        sums[name] = sums.get(name, np.zeros(3, complex)) + each.waves(best[1])
    return Guess(axes=best[1], shifts={name: np.angle(value) / (2.0 * np.pi) for name, value in sums.items()})


def off_by(guess: Guess, axes: FloatArray, shift: FloatArray, spacing: float) -> tuple[float, FloatArray]:
    """Return how far a guess is from a lattice: degrees, and turns (3,) of its waves at the middle of the model.

    A cubic lattice is the same in 24 turns, and mirrored: the nearest counts.
    """
    best = (np.inf, np.eye(3))
    for order in permutations(range(3)):
        for signs in product((-1.0, 1.0), repeat=3):
            exchange = np.eye(3)[list(order)] * np.array(signs)[:, None]
            between = guess.axes @ (exchange @ axes).T
            if np.linalg.det(between) < 0.0:
                continue
            angle = float(np.degrees(np.arccos(np.clip((np.trace(between) - 1.0) / 2.0, -1.0, 1.0))))
            if angle < best[0]:
                best = angle, exchange
    return best[0], np.mod(guess.shift(spacing) - best[1] @ shift + 0.5, 1.0) - 0.5


def _starts(sphere: FloatArray, power: FloatArray) -> list[FloatArray]:
    """Return axes (3, 3) whose directions are peaks, the strongest triples first."""
    peaks: list[int] = []
    for place in np.argsort(-power):
        if all(abs(sphere[place] @ sphere[other]) < np.cos(np.radians(4.0)) for other in peaks):
            peaks.append(int(place))
        if len(peaks) == PEAKS:
            break

    def near(direction: FloatArray) -> float:
        return float(power[np.argmax(np.abs(sphere @ direction))])

    found = []
    for row, one in enumerate(peaks):
        for other in peaks[row + 1 :]:
            u, v = sphere[one], sphere[other]
            v = _unit((v - u * (u @ v))[None])[0]
            if abs(u @ sphere[other]) < np.sin(np.radians(6.0)):
                w = np.cross(u, v)
                found.append((near(u) + near(v) + near(w), np.array([u, v, w])))
    found.sort(key=lambda entry: -entry[0])
    if not found:  # no two peaks are at right angles
        u = sphere[peaks[0]]
        v = _unit(np.cross(u, np.eye(3)[np.argmin(np.abs(u))])[None])[0]
        return [np.array([u, v, np.cross(u, v)])]
    return [axes for _, axes in found[:STARTS]]


def _sphere(count: int) -> FloatArray:
    """Return directions (count, 3), one of each pair of opposite ones, evenly spread (a Fibonacci spiral)."""
    height = (np.arange(count) + 0.5) / count
    angle = np.pi * (1.0 + 5.0**0.5) * (np.arange(count) + 0.5)
    radius = np.sqrt(1.0 - height**2)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
