"""Deep 3D mesh watermarking (Wang et al. 2022): a network marks, and another reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.frame import Frame, canonical_frame, frame_alternatives
from meshmark.mesh import FloatArray
from meshmark.research.schemes.rivals.deep3d.inputs import Shown, mean_of_neighbours, shown
from meshmark.research.schemes.rivals.deep3d.network import Read, shipped_network
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.rival import Rival
from meshmark.research.schemes.scheme import Bits

__all__ = ["Deep3d"]

# Of the budget, what is used: the rest is for rounding.
USED = 0.999
# A bit that the extractor reads by this much is safe; so much of the mark the first round of refining changes.
SAFE, STEP = 2.0, 0.5


@dataclass(frozen=True)
class Deep3d(Rival):
    """The embedder moves each point along its normal; the extractor reads all points at once.

    refinements: rounds in which the mark is improved along the gradient of what the extractor reads; 0 is the
    published scheme.
    """

    title = "Deep 3D"
    source = "Wang et al. 2022"
    reconstruction = (
        "sizes, inputs, moves along normals, the canonical frame, refining along the extractor's gradient, key and "
        "pilots are ours; it starts as spread spectrum on waves, which 16 minutes of training on one core improved "
        "little"
    )
    pilots: int = 16
    refinements: int = 6

    def _placed(self, host: Host, code: Bits, _key: Key, budget: float) -> FloatArray:
        network, look = shipped_network(), _Look(host)
        message = 2.0 * code.astype(np.float32) - 1.0
        size = USED * budget * host.diagonal
        heights = look.scaled(network.heights(look.shown(host.points), message), size)
        best, least, step, down = heights, np.inf, STEP, heights
        for number in range(self.refinements + 1):
            seen = look.shown(look.moved(heights))
            read = Read(network, seen)
            margins = message * read.logits
            loss = float(np.logaddexp(0.0, SAFE - margins).mean())
            if loss < least:
                best, least = heights, loss
                by_logits = message / (1.0 + np.exp(margins - SAFE))
                slope = seen.by_heights(read.gradient(by_logits))
                down = look.scaled(np.tanh(slope / (slope.std() or 1.0)), size)
            else:
                step /= 2.0
            if margins.min() >= SAFE or number == self.refinements:
                break
            heights = look.scaled(best + step * down, size)
        return look.moved(best)

    def _seen(self, host: Host, _key: Key, _reference: Any) -> tuple[FloatArray, int]:
        """The frame in which the extractor says most is the right one, whatever it says."""
        look, network = _Look(host), shipped_network()
        found = [Read(network, look.seen_in(frame)).logits for frame in frame_alternatives(look.frame)]
        return -max(found, key=lambda logits: float(np.abs(logits).sum())).astype(np.float64), 1


class _Look:
    """A host as the network sees it, whatever its size and pose, and moves of its points along their normals."""

    def __init__(self, host: Host) -> None:
        self._host, self._mean = host, mean_of_neighbours(host.graph)
        self.frame = canonical_frame(host.points, host.faces)
        self._normals = vertex_normals(host.points, host.faces)

    def seen_in(self, frame: Frame) -> Shown:
        """Return what the network sees in this frame."""
        return shown(frame.to_canonical(self._host.points), self._host.faces, self._mean)

    def shown(self, points: FloatArray) -> Shown:
        """Return the same with the points at other places, in the frame nearest to the host's."""
        frames = frame_alternatives(canonical_frame(points, self._host.faces))
        nearest = max(frames, key=lambda frame: float((frame.axes * self.frame.axes).sum()))
        return shown(nearest.to_canonical(points), self._host.faces, self._mean)

    def moved(self, heights: FloatArray) -> FloatArray:
        """Return the points moved along their normals by heights (p,)."""
        return self._host.points + heights[:, None] * self._normals

    def scaled(self, heights: Any, size: float) -> FloatArray:
        """Return heights (p,) that move the model's vertices by an RMS of `size`."""
        moves = self._host.rms(self.moved(heights)) * self._host.diagonal
        if not moves > 0.0:
            raise CapacityError("the network moves no point of the model")
        return np.asarray(heights * (size / moves), np.float64)
