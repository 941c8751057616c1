"""Volume moments of patches, quantised (K. Wang, G. Lavoue, F. Denis, A. Baskurt 2011)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from meshmark.coding.keyed import keyed_words, unit_interval
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.geometry.areas import vertex_areas_and_normals
from meshmark.geometry.open_edges import open_edges
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.ownership.carriers.quantisation import bit_phase, nearest_offsets
from meshmark.research.schemes.rivals.codeword import coded, order_of
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.rival import Rival
from meshmark.research.schemes.rivals.volumes import Solid, memberships, solid_of, volumes
from meshmark.research.schemes.scheme import Bits

__all__ = ["VolumeMoments"]

# Steps in means of a bit's volume, falling: the reader tries them all.
STEPS = 0.6 * 1.15 ** -np.arange(50.0)
# Rounds of the solver, and how near to their lattice points the bits shall come, RMS in steps.
ROUNDS, NEAR = 4, 0.02
# So much of the budget is planned for; the rest is for what the plan does not see.
PLANNED = 0.95
# Ways to move the bits' volumes that reach less than this share of the mean are left: the frame takes them back.
STIFF = 0.01
# A change of the frame to see what it does to the volumes.
SMALL = 1e-4
# The proper turns of the axes that their signs may be mistaken for.
TURNS = np.array([(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)])


@dataclass(frozen=True, kw_only=True)
class VolumeMoments(Rival):
    """Each code bit has patches of directions from the volume's centroid; the volume in them is quantised.

    patches: for each code bit, in a keyed choice. step: in means of a bit's volume, where the reader knows it;
    otherwise it is tuned to the budget, and the reader seeks it.
    """

    title = "Volume moments"
    source = "Wang, Lavoue, Denis, Baskurt 2011"
    reconstruction = (
        "patches by spherical direction with smooth borders, several for each bit, their masks, the solver, "
        "key and pilots are ours"
    )
    pilots: int = 16
    patches: int = 3
    step: float | None = None

    def step_within(self, mesh: Mesh, bits: Bits, key: Key, budget: float) -> float:
        """Return the step at which a mesh carries the bits within a budget, RMS over the diagonal."""
        return self._tuned(Host(mesh), coded(self._payload(bits), key, self.pilots), key, budget)[0]

    @property
    def _steps(self) -> FloatArray:
        return STEPS if self.step is None else np.array([self.step])

    def _placed(self, host: Host, code: Bits, key: Key, budget: float) -> FloatArray:
        return self._tuned(host, code, key, budget)[1]

    def _tuned(self, host: Host, code: Bits, key: Key, budget: float) -> tuple[float, FloatArray]:
        if len(open_edges(host.faces, len(host.points))[0]):
            raise CapacityError(
                f"the model is not closed, {self.title} needs a surface with an inside and an outside"
            )
        seen = solid_of(host.points, host.faces)
        if seen is None:
            raise CapacityError(f"the model has no volume, {self.title} needs a solid")
        plan = _Plan(_Reader(self._length, self.patches, key), host, *seen)
        affordable = (step for step in self._steps if plan.rms(code, float(step)) <= budget)
        for step in affordable:
            points = plan.solved(code, float(step))
            if host.rms(points) <= budget:
                return float(step), points
        raise CapacityError(f"the finest step of {self.title} moves the model by more than the budget")

    def _seen(self, host: Host, key: Key, _reference: Any) -> tuple[FloatArray, int]:
        found = solid_of(host.points, host.faces)
        best, best_seen = 0.0, np.zeros(self._length)
        if found is None or len(open_edges(host.faces, len(host.points))[0]):
            return best_seen, 1
        reader = _Reader(self._length, self.patches, key)
        solid, axes = found
        for turn in TURNS:
            shares = reader.shares(host.points, host.faces, solid.centre, axes * turn)
            for step in self._steps:
                phase = bit_phase(shares, reader.dither, float(step))
                score = float(np.cos(2.0 * phase).sum())
                if score > best:
                    best, best_seen = score, np.cos(phase)
        return best_seen, 1


class _Reader:
    """What the key makes of directions: the bit that each patch belongs to, and a dither (c,) for each bit."""

    def __init__(self, length: int, patches: int, key: Key) -> None:
        self.length, self.patches = length, length * patches
        self.bit = order_of(key, "volume patches", self.patches) % length
        self.dither = unit_interval(keyed_words(key.subkey("volume dither"), length))

    def shares(self, points: FloatArray, faces: IntArray, centre: FloatArray, axes: FloatArray) -> FloatArray:
        """Return the volume of each bit's patches (c,), 1 on average."""
        held = np.bincount(self.bit, volumes((points - centre) @ axes, faces, self.patches), self.length)
        total = float(held.sum())
        return np.asarray(held * self.length / total if total != 0.0 else held)

    def masks(self, places: FloatArray) -> csr_array:
        """Return (n, c): how much each place in the frame belongs to the patches of each bit."""
        group = csr_array((np.ones(self.patches), (np.arange(self.patches), self.bit)))
        return csr_array(memberships(places, self.patches) @ group)


class _Plan:
    """How the volumes of the bits change when the points of a host move along their normals by smooth masks."""

    def __init__(self, reader: _Reader, host: Host, solid: Solid, axes: FloatArray) -> None:
        self.reader, self.host, self.solid, self.axes = reader, host, solid, axes
        self.shares = self._shares(host.points, solid)
        areas, self.normals = vertex_areas_and_normals(host.points, host.faces)
        self.masks = reader.masks((host.points - solid.centre) @ axes)
        swept = csr_array(self.masks.multiply(areas[:, None] / solid.volume))
        change = reader.length * (self.masks.T @ swept).toarray() + self._by_frame(swept)
        power = (self.masks.T @ self.masks).toarray() / len(host.points)
        power += 1e-9 * np.trace(power) * np.eye(reader.length)
        toward = np.linalg.solve(power, change.T)
        reach = change @ toward
        reach += STIFF * np.trace(reach) / reader.length * np.eye(reader.length)
        self.heights = np.linalg.solve(reach, toward.T).T
        self.cost = np.asarray(np.linalg.inv(reach), np.float64)

    def _shares(self, points: FloatArray, solid: Solid) -> FloatArray:
        axes = solid.axes()
        axes = axes * np.sign(np.einsum("ij,ij->j", axes, self.axes))
        return self.reader.shares(points, self.host.faces, solid.centre, axes)

    def _by_frame(self, swept: csr_array) -> FloatArray:
        """Return (c, c): what moving each bit's masks does to the shares by moving the frame."""
        arms = self.host.points - self.solid.centre
        moved = swept.T @ arms
        spread = (swept.T @ (arms[:, :, None] * arms[:, None, :]).reshape(-1, 9)).reshape(-1, 3, 3)
        spread -= np.asarray(swept.sum(axis=0))[:, None, None] * self.solid.covariance
        size = float(np.sqrt(np.trace(self.solid.covariance)))
        change = np.zeros((self.reader.length, self.reader.length))
        for i in range(3):
            step = SMALL * size * np.eye(3)[i]
            other = replace(self.solid, centre=self.solid.centre + step)
            change += np.outer(self._shares(self.host.points, other) - self.shares, moved[:, i]) / (
                SMALL * size
            )
            for j in range(i, 3):
                turn = np.zeros((3, 3))
                turn[i, j] = turn[j, i] = SMALL * size**2
                other = replace(self.solid, covariance=self.solid.covariance + turn)
                by = (self._shares(self.host.points, other) - self.shares) / (SMALL * size**2)
                change += np.outer(by, spread[:, i, j])
        return change

    def changes(self, code: Bits, step: float) -> FloatArray:
        """Return by how much each share shall change to lie on a lattice point of its bit, cheaply."""
        return nearest_offsets(self.shares, self.reader.dither, code.astype(np.int64), step, self.cost)

    def rms(self, code: Bits, step: float) -> float:
        """Return about what the mark moves the points by, RMS over the diagonal and the planned share."""
        moved = self.masks @ (self.heights @ self.changes(code, step))
        return float(np.sqrt(np.mean(moved**2))) / self.host.diagonal / PLANNED

    def solved(self, code: Bits, step: float) -> FloatArray:
        """Return the points moved until the reader sees each bit on its lattice point, frame and all."""
        goal, heights = self.shares + self.changes(code, step), np.zeros(len(code))
        points, best, least = self.host.points, self.host.points, np.inf
        for _ in range(ROUNDS):
            found = solid_of(points, self.host.faces)
            if found is None:
                break
            off = goal - self._shares(points, found[0])
            far = float(np.sqrt(np.mean(off**2))) / step
            if far < least:
                best, least = points, far
            if far < NEAR:
                break
            heights = heights + self.heights @ off
            points = self.host.points + (self.masks @ heights)[:, None] * self.normals
        return best
