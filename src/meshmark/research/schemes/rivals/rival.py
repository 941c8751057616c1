"""What all rivals share: payload and key, the budget, and a mark that is read back before it is returned."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS
from meshmark.errors import CapacityError, InputError
from meshmark.mesh import FloatArray, Mesh
from meshmark.research.schemes.rivals.alignment import differences
from meshmark.research.schemes.rivals.codeword import coded, read_code
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.scheme import Bits, Readout
from meshmark.strengths import BUDGETS, check_strength
from meshmark.threads import on_one_thread

__all__ = ["Informed", "Rival"]


class Rival(ABC):
    """A published scheme: places code bits in points, and sees them again.

    pilots: keyed bits beside the payload that tell whether a mark is there; 0 is the published scheme without them,
    which says of every mesh that no mark is present.
    reconstruction: what of it is ours where the source does not say, in one sentence.
    """

    title: str
    source: str
    reconstruction: str
    bits = ID_BITS
    blind = True
    pilots: int

    @on_one_thread
    def embed(self, mesh: Mesh, bits: Bits, key: Key, *, strength: str = "standard") -> Mesh:
        """See `Scheme.embed`; raises `CapacityError` where its own reader would not find the mark."""
        payload = self._payload(bits)
        check_strength(strength)
        marked = self.marked(mesh, payload, key, BUDGETS[strength])
        if self.pilots and not self.extract(marked, key, reference=mesh).present:
            raise CapacityError(
                f"the model cannot carry the mark: {self.title} does not find it where it was put"
            )
        return marked

    def marked(self, mesh: Mesh, bits: Bits, key: Key, budget: float) -> Mesh:
        """Return the mesh carrying the bits (n,) within a budget, RMS over the diagonal; it is not read back."""
        host = Host(mesh)
        return host.moved(self._placed(host, coded(self._payload(bits), key, self.pilots), key, budget))

    @on_one_thread
    def extract(self, mesh: Mesh, key: Key, *, reference: Any = None) -> Readout:
        """See `Scheme.extract`."""
        seen, tried = self._seen(Host(mesh), key, reference)
        return read_code(seen, key, self.pilots, tried)

    def _payload(self, bits: Bits) -> Bits:
        if np.shape(bits) != (self.bits,):
            raise InputError(f"the payload has shape {np.shape(bits)}, expected ({self.bits},)")
        return np.asarray(bits, np.uint8)

    @property
    def _length(self) -> int:
        return self.bits + self.pilots

    @abstractmethod
    def _placed(self, host: Host, code: Bits, key: Key, budget: float) -> FloatArray:
        """Return the places (p, 3) of the points that carry the code bits (c,)."""

    @abstractmethod
    def _seen(self, host: Host, key: Key, reference: Any) -> tuple[FloatArray, int]:
        """Return a number for each code bit (c,), positive for 0, 0 for none, and how many readings were tried."""


class Informed(Rival):
    """A rival that reads by comparing with the unmarked original."""

    blind = False

    def _seen(self, host: Host, key: Key, reference: Any) -> tuple[FloatArray, int]:
        if not isinstance(reference, Mesh):
            raise InputError(f"{self.title} is not blind, expected the unmarked original as reference")
        original = Host(reference)
        moved, weights = differences(original, host)
        return self._compared(original, moved, weights, key) if weights.any() else np.zeros(self._length), 1

    @abstractmethod
    def _compared(self, original: Host, moved: FloatArray, weights: FloatArray, key: Key) -> FloatArray:
        """Return a number for each code bit (c,) from how far each point (p, 3) of the original has moved.

        weights: (p,), 0 for points that were not found again; not all are 0.
        """
