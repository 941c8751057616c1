"""An attacker who may ask for the default JSON of any model, as often as he likes, and holds one marked model.

He removes the mark by a decision-based attack: from a field of bumps that takes the id away he steps along the
boundary between read and not read, whose slope he estimates from answers to random changes, towards less
displacement (after Chen, Jordan and Wainwright, HopSkipJumpAttack, 2020, arXiv:1904.02144), and leaves parts of the
surface alone that were not needed. What the answers say of
single places is also his evidence of the lattice's pose. He knows all candidates of the spacing, and is granted the
right one.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from itertools import islice
from time import monotonic

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import meshmark as mm
from claims.security.donors import Donor, donors
from claims.security.options import KEY, Options
from claims.security.pose import Energy
from claims.security.table import Figure
from claims.security.washing import moved_along
from meshmark.coding.message import format_id
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, Mesh

__all__ = ["Climber", "Oracle", "answered", "oracle", "pose_chance"]

MODELS, QUERIES = 1, 10_000
# Distance of bumps and their radius, in spacings.
APART, RADIUS = 0.45, 0.55
STARTS, HALVINGS = 8, 4
# Probes of the first estimate of the slope; their size beside the field.
PROBES, PROBE = 24, 0.35
# Parts that are tried without bumps after each step, and their share of these.
PARTS, PART = 6, (0.02, 0.15)
LARGEST = 4.0
"""Largest displacement at which the id must be gone, over the mark's own."""


def answered(mesh: Mesh) -> str:
    """Return what `meshmark extract --json` says of a model without --diagnose."""
    return json.dumps(mm.extract(mesh, KEY).to_dict())


@dataclass(eq=False, kw_only=True)
class Oracle:
    """Answers about displaced copies of a marked model, whose number is counted."""

    marked: Mesh
    id: int
    queries: int = 0
    bands: list[float] = field(default_factory=list)

    def is_gone(self, moved: FloatArray) -> bool:
        """Return whether the id is not read once the points are moved by `moved` (p,), shares of the diagonal."""
        self.queries += 1
        said = json.loads(answered(moved_along(self.marked, moved, 1.0)))
        self.bands.append(said["log10_false_positive"])
        return format_id(self.id) not in said["ids"]


class Climber:
    """The attack on one model. size: RMS displacement at which the id is gone; evidence: (k,) of single bumps."""

    def __init__(self, donor: Donor, oracle: Oracle, rng: np.random.Generator) -> None:
        surface = surface_of(donor.marked)
        self.places = surface.frame.to_canonical(surface.points)
        self._oracle, self._rng, self._own = oracle, rng, donor.rms
        self.centres = _spread(self.places, APART * donor.mark.spacing, rng)
        self.bumps = _bumps(self.places, self.places[self.centres], RADIUS * donor.mark.spacing)
        self.evidence = np.zeros(len(self.centres))
        self.best: FloatArray | None = None

    @property
    def size(self) -> float:
        """Return the displacement found so far, over the mark's own; infinite where none takes the id away."""
        return np.inf if self.best is None else self._rms(self.best) / self._own

    def climb(self, queries: int, end: float) -> None:
        """Ask at most about so many times."""
        for _ in range(STARTS):
            heights = self._rng.normal(size=len(self.centres))
            heights *= LARGEST * self._own / self._rms(heights)
            if self.best is None or self._is_gone(0.99 * heights * self._rms(self.best) / self._rms(heights)):
                self._take(
                    heights if self.best is None else heights * self._rms(self.best) / self._rms(heights)
                )
            if self._oracle.queries >= queries or monotonic() > end:
                return
        turn = 0
        while self.best is not None and self._oracle.queries < queries and monotonic() < end:
            turn += 1
            slope = self._slope(min(round(PROBES * np.sqrt(turn)), queries - self._oracle.queries), end)
            reach = self._rms(self.best) / np.sqrt(turn)
            for _ in range(HALVINGS):
                ahead = self.best + slope * reach / self._rms(slope)
                if self._is_gone(ahead):
                    self._take(ahead)
                    break
                reach *= 0.5
            self._drop_parts(queries, end)
            print(f"  {self._oracle.queries} queries: {self.size:.3f}", flush=True)

    def _slope(self, probes: int, end: float) -> FloatArray:
        """Return the direction (k,) in which the id is sooner lost, from answers about random changes."""
        assert self.best is not None
        size = PROBE * self._rms(self.best)
        asked, said = [], []
        for _ in range(max(probes, 2)):
            change = self._rng.choice([-1.0, 1.0], size=len(self.centres))
            asked.append(change)
            said.append(1.0 if self._is_gone(self.best + change * size / self._rms(change)) else -1.0)
            if monotonic() > end:
                break
        weights = np.array(said)
        if abs(weights.mean()) < 1.0:
            weights = weights - weights.mean()
        slope = weights @ np.array(asked) / len(asked)
        self.evidence += slope * len(asked)
        return np.asarray(slope)

    def _drop_parts(self, queries: int, end: float) -> None:
        """Leave out the bumps of parts of the surface that were not needed."""
        assert self.best is not None
        places = self.places[self.centres]
        for _ in range(PARTS):
            if self._oracle.queries >= queries or monotonic() > end:
                return
            apart = np.linalg.norm(places - self._rng.choice(places), axis=1)
            without = np.where(apart < np.quantile(apart, self._rng.uniform(*PART)), 0.0, self.best)
            if self._is_gone(without):
                self.best = without

    def _take(self, heights: FloatArray) -> None:
        """Keep a field, made as small as it may be, where it is smaller than that before."""
        low, high = 0.0, 1.0
        for _ in range(HALVINGS + 1):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self._is_gone(middle * heights) else (middle, high)
        taken = high * heights
        if high == 1.0 and self.best is None and not self._is_gone(taken):
            return
        if self.best is None or self._rms(taken) < self._rms(self.best):
            self.best = taken

    def _is_gone(self, heights: FloatArray) -> bool:
        return self._oracle.is_gone(self.bumps @ heights)

    def _rms(self, heights: FloatArray) -> float:
        return float(np.sqrt(np.mean((self.bumps @ heights) ** 2)))


def oracle(options: Options) -> list[Figure]:
    """Return how far the attack gets on each model, and whether its evidence leans to the true pose."""
    queries = QUERIES if options.tries is None else options.tries
    sizes, chances, asked, bands = [], [], [], set()
    for number, donor in enumerate(islice(donors(options), options.count(MODELS))):
        asking = Oracle(marked=donor.marked, id=donor.id)
        climber = Climber(donor, asking, options.rng(20, number))
        print(f"{donor.name}: {len(climber.places)} points, {len(climber.centres)} bumps", flush=True)
        climber.climb(queries, options.end)
        sizes.append(climber.size)
        chances.append(pose_chance(climber, donor, options.rng(21, number)))
        asked.append(asking.queries)
        bands |= set(asking.bands)
        print(f"  removed at {sizes[-1]:.2f} of the mark's RMS; pose {chances[-1]:.2f}", flush=True)
    return [
        Figure(
            name="displacement that takes the id away, over the mark's own RMS",
            measured=f"median {np.median(sizes):.2f}, least {min(sizes):.2f}",
            of=f"{len(sizes)} models, {min(asked):,} to {max(asked):,} queries",
            bar="at least .90",
            met=min(sizes) >= 0.9,
        ),
        Figure(
            name="random poses that the evidence fits as well as the true one",
            measured=", ".join(f"{each:.3f}" for each in chances),
            of=f"{len(sizes)} models",
            bar="share above .01",
            met=min(chances) > 0.01,
        ),
        Figure(
            name="different bounds in the answers",
            measured=", ".join(f"{each:g}" for each in sorted(bands)),
            of=f"{sum(asked):,} answers",
        ),
    ]


def pose_chance(climber: Climber, donor: Donor, rng: np.random.Generator, draws: int = 1000) -> float:
    """Return the share of random poses whose lattice explains where answers changed as well as the true one."""
    weights = np.abs(climber.evidence)
    places = climber.places[climber.centres]
    energy = Energy(places=places, weights=weights - weights.mean(), spacing=donor.mark.spacing, scale=1.0)

    def fit(axes: FloatArray, shift: FloatArray) -> float:
        return float(np.real(energy.waves(axes) * np.exp(-2j * np.pi * shift)).sum())

    true = fit(donor.lattice.axes, donor.lattice.shift)
    random = [fit(Rotation.random(random_state=rng).as_matrix(), rng.uniform(size=3)) for _ in range(draws)]
    return float(np.mean([each >= true for each in random]))


def _spread(places: FloatArray, apart: float, rng: np.random.Generator) -> np.ndarray:
    """Return points no two of which are nearer than `apart`."""
    tree, free, chosen = cKDTree(places), np.ones(len(places), bool), []
    for place in rng.permutation(len(places)):
        if free[place]:
            chosen.append(int(place))
            free[tree.query_ball_point(places[place], apart)] = False
    return np.array(chosen)


def _bumps(places: FloatArray, centres: FloatArray, radius: float) -> sp.csr_array:
    """Return (p, k): the height of each bump at each point."""
    near = cKDTree(places).sparse_distance_matrix(cKDTree(centres), radius, output_type="coo_matrix")
    heights = (1.0 - (near.data / radius) ** 2) ** 3
    # A distance of 0 is not stored: centres are points, whose own bump is 1 high there.
    found = sp.coo_array((heights, (near.row, near.col)), shape=near.shape).tolil()
    for column, row in enumerate(np.asarray(cKDTree(places).query(centres)[1]).tolist()):
        found[row, column] = 1.0
    return sp.csr_array(found)
