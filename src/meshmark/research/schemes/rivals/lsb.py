"""The least significant bits of coordinates, replaced (folklore)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.mesh import FloatArray, IntArray
from meshmark.research.schemes.rivals.codeword import order_of, votes
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.rival import Rival
from meshmark.research.schemes.scheme import Bits

__all__ = ["Lsb"]


@dataclass(frozen=True)
class Lsb(Rival):
    """Coordinates are whole numbers of a decimal unit; the last bit of each carries a code bit, in a keyed order.

    digits: decimals of the model's size, written as d.ddd... 10^e, that are kept. With 12 it is a change that only
    double precision holds, far below the budget: more would be the quantisation of coordinates, not their last bit.
    """

    title = "Least significant bits"
    source = "folklore"
    reconstruction = "the decimal unit, the keyed order and the majority over all coordinates are ours"
    pilots: int = 32
    digits: int = 12

    def _placed(self, host: Host, code: Bits, key: Key, _budget: float) -> FloatArray:
        if host.points.size < self._length:
            raise CapacityError(
                f"the model has {host.points.size} coordinates, expected at least {self._length}"
            )
        unit = self._unit(host)
        whole = np.rint(host.points / unit).astype(np.int64)
        bits = code[self._order(host, key)]
        return np.asarray(unit * (whole - (whole & 1) + bits))

    def _seen(self, host: Host, key: Key, _reference: Any) -> tuple[FloatArray, int]:
        last = np.rint(host.points / self._unit(host)).astype(np.int64) & 1
        return votes(self._order(host, key), np.asarray(1.0 - 2.0 * last, np.float64), self._length), 1

    def _unit(self, host: Host) -> float:
        size = np.abs(host.points).max()
        return float(10.0 ** (np.floor(np.log10(size if size > 0.0 else 1.0)) - self.digits))

    def _order(self, host: Host, key: Key) -> IntArray:
        """Return (p, 3): the code bit that each coordinate carries, each about as often as the others."""
        return (order_of(key, "lsb", host.points.size) % self._length).reshape(-1, 3)
