"""Which symbols of a segment are wrong: belief propagation on the graph of the erasure code.

All bits of a symbol are right together or random together, so the bits that the rest of the graph already knows
tell how far the others are to be trusted.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.erasure.graph import Graph
from meshmark.mesh import FloatArray, IntArray

__all__ = ["trust"]

ROUNDS, STILL = 60, 1e-3
# What share of the symbols is taken to be wrong.
WRONG = 0.02
SURE = 1.0 - 1e-9
NOTHING = 1e-12

Symbols = NDArray[np.uint16]


def trust(graph: Graph, index: NDArray[np.uint32], value: Symbols, symbol_bits: int) -> FloatArray:
    """Return (n,): for each symbol of a segment the logarithm of the odds that it is right."""
    row, symbol = graph.edges(index)
    parity, tied = graph.sparse_rows
    order = np.argsort(parity, kind="stable")
    row = np.concatenate([row, len(index) + parity[order]])
    symbol = np.concatenate([symbol, tied[order]])
    bits = (value[:, None] >> np.arange(symbol_bits, dtype=np.uint16)) & np.uint16(1)
    side = 1.0 - 2.0 * bits.astype(float)
    rows, columns = _Groups(row), _Groups(symbol)
    belief = np.zeros((len(row), symbol_bits))
    odds = np.zeros(len(index))
    near = np.zeros(belief.shape)
    for number in range(ROUNDS):
        before, near = near, np.tanh(0.5 * belief)
        if number and np.abs(near - before).max() < STILL:
            break
        size, sign = np.log(np.maximum(np.abs(near), NOTHING)), np.where(near < 0.0, -1.0, 1.0)
        whole, turned = rows.sums(size), rows.products(sign)
        odds, heard = _received(np.exp(whole[: len(index)]) * turned[: len(index)], side)
        channel = np.ones((rows.count, symbol_bits))
        channel[: len(index)] = heard
        message = np.exp(whole[row] - size) * turned[row] * sign * channel[row]
        message = 2.0 * np.arctanh(np.clip(message, -SURE, SURE))
        belief = columns.sums(message)[symbol] - message
    return odds


def _received(known: FloatArray, side: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the odds (n,) that symbols are right, and what their bits say (n, bits) given their other bits.

    known: (n, bits) what the graph says of them; side: (n, bits) what was received; 1 is a zero bit, -1 a one.
    """
    agree = np.log(np.maximum(0.5 * (1.0 + side * np.clip(known, -SURE, SURE)), NOTHING))
    total = agree.sum(axis=1, keepdims=True)
    prior = np.log((1.0 - WRONG) / WRONG) + side.shape[1] * np.log(2.0)
    weight = np.exp(np.clip(prior + total - agree, -30.0, 30.0))
    return (prior + total)[:, 0], side * weight / (weight + 2.0)


class _Groups:
    """Rows of an array by group, for sums and products over groups."""

    def __init__(self, group: IntArray) -> None:
        self.order = np.argsort(group, kind="stable")
        self.sorted = bool((group[1:] >= group[:-1]).all())
        self.names, self.starts = np.unique(group[self.order], return_index=True)
        self.count = int(group.max(initial=-1)) + 1

    def sums(self, values: FloatArray) -> FloatArray:
        out = np.zeros((self.count, values.shape[1]))
        out[self.names] = np.add.reduceat(self._ordered(values), self.starts)
        return out

    def products(self, values: FloatArray) -> FloatArray:
        out = np.ones((self.count, values.shape[1]))
        out[self.names] = np.multiply.reduceat(self._ordered(values), self.starts)
        return out

    def _ordered(self, values: FloatArray) -> FloatArray:
        return values if self.sorted else values[self.order]
