"""Minimum-distortion quantisation of spherical angles, in units that verify themselves (Borah, Borah 2019)."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.keyed import cell_words, keyed_words, unit_interval
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.geometry.frame import canonical_frame
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.ownership.carriers.quantisation import bit_phase
from meshmark.research.schemes.rivals.angles import Angles, angles_of, turned
from meshmark.research.schemes.rivals.codeword import order_of, votes
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.rival import Rival
from meshmark.research.schemes.rivals.traversal import traversal
from meshmark.research.schemes.scheme import Bits

__all__ = ["Mdaqim"]

# Steps are 2 pi over one of these, so that a full turn holds a whole number of them: the reader tries them all.
STEPS = 2.0 * np.pi / np.unique(2 * np.rint(30 * 1.08 ** np.arange(72)))
# Marking moves the frame a little: so often the marked model's own frame is sought.
PASSES = 3
# Number of angles from which the step is estimated.
ENOUGH = 8_000


@dataclass(frozen=True)
class Mdaqim(Rival):
    """Both angles of a vertex, seen from the model's canonical frame, go to the nearest lattice point of a bit.

    Vertices are taken in the order of a search through the mesh, breadth first, from a keyed start; each `unit` of
    them ends with one whose two bits are a keyed hash of the quantised angles of the others. Many angles carry each
    code bit, and all of them read it.
    """

    title = "3D-MDAQIM"
    source = "Borah, Borah 2019"
    reconstruction = "canonical frame, traversal, hash and size of units, repetition and pilots are ours"
    pilots: int = 32
    unit: int = 8

    def verify(self, mesh: Mesh, key: Key) -> tuple[IntArray, NDArray[np.bool_]]:
        """Return the vertices (u, unit) of the complete units, as points of `Host`, and which of them verify (u,).

        An altered unit verifies with a chance of 1/4.
        """
        host = Host(mesh)
        plan = _Plan(self, host, key)
        angles = _angles(host, host.points, plan.order)
        step = plan.likeliest_step(angles)
        whole = len(plan.order) // self.unit
        read = bit_phase(angles.values, plan.dither, step)[plan.last][:whole]
        expected = plan.hashes(angles, step)[:whole]
        holds = ((np.cos(read) < 0.0) == expected.astype(bool)).all(axis=1)
        return plan.order[: whole * self.unit].reshape(whole, self.unit), holds

    def _placed(self, host: Host, code: Bits, key: Key, budget: float) -> FloatArray:
        plan = _Plan(self, host, key)
        if 2 * (len(plan.order) - len(plan.order) // self.unit) < self._length:
            raise CapacityError(
                f"the model has {len(host.points)} points, {self.title} needs at least {self._length}"
            )

        def affordable(step: float) -> bool:
            return host.rms(self._quantised(host, plan, code, step)) <= budget

        first = bisect_left(STEPS, True, key=affordable)
        if first < len(STEPS):
            return self._quantised(host, plan, code, float(STEPS[first]))
        raise CapacityError(f"the finest step of {self.title} moves the model by more than the budget")

    def _quantised(self, host: Host, plan: _Plan, code: Bits, step: float) -> FloatArray:
        points = host.points
        for _ in range(PASSES):
            # The model as it was, seen in the frame of the last try: moving that on would turn the frame along.
            angles = angles_of(host.points[plan.order], canonical_frame(points, host.faces))
            bits = code[plan.bit]
            placed = angles.quantised(bits, plan.dither, step)
            bits[plan.last] = plan.hashes(placed, step)
            points = turned(host.points, plan.order, angles.quantised(bits, plan.dither, step))
        return points

    def _seen(self, host: Host, key: Key, _reference: Any) -> tuple[FloatArray, int]:
        plan = _Plan(self, host, key)
        angles = _angles(host, host.points, plan.order)
        seen = angles.weights * np.cos(bit_phase(angles.values, plan.dither, plan.likeliest_step(angles)))
        seen[plan.last] = 0.0
        return votes(plan.bit, seen, self._length), 1


class _Plan:
    """What the key makes of a mesh's connectivity: the order of points, their bits (n, 2) and dithers (n, 2).

    last: rows of the points that end a unit.
    """

    def __init__(self, scheme: Mdaqim, host: Host, key: Key) -> None:
        count = len(host.points)
        start = int(keyed_words(key.subkey("mdaqim start"), 1)[0] % np.uint64(count))
        self.order = traversal(host.graph, start)
        self.unit = scheme.unit
        self.last = np.arange(scheme.unit - 1, count, scheme.unit)
        places = order_of(key, "mdaqim places", 2 * count) % (scheme.bits + scheme.pilots)
        self.bit: IntArray = places.reshape(count, 2)
        self.dither = unit_interval(keyed_words(key.subkey("mdaqim dither"), 2 * count)).reshape(count, 2)
        self._hash_key = key.subkey("mdaqim hash")

    def hashes(self, angles: Angles, step: float) -> Bits:
        """Return (u, 2): two bits for each whole unit, a keyed hash of the lattice points of the others."""
        units = len(self.last)
        half_steps = np.rint(2.0 * (angles.values / step - self.dither)).astype(np.int64)
        half_steps[:, 1] %= np.int64(np.rint(4.0 * np.pi / step))
        rows = half_steps[: units * self.unit].reshape(units, self.unit, 2)[:, :-1].reshape(units, -1)
        words = cell_words(self._hash_key, rows, 1)[:, 0]
        return np.column_stack([words & np.uint64(1), (words >> np.uint64(1)) & np.uint64(1)]).astype(
            np.uint8
        )

    def likeliest_step(self, angles: Angles) -> float:
        """Return the step whose lattice the angles lie on best; the bits do not matter for it."""
        surest = np.argsort(-angles.weights.ravel(), kind="stable")[:ENOUGH]
        values, dither = angles.values.ravel()[surest], self.dither.ravel()[surest]
        scores = [float(np.cos(2.0 * bit_phase(values, dither, float(step))).sum()) for step in STEPS]
        return float(STEPS[int(np.argmax(scores))])


def _angles(host: Host, points: FloatArray, order: IntArray) -> Angles:
    return angles_of(points[order], canonical_frame(points, host.faces))
