"""Ordered-statistics decoding of any binary linear code (Fossorier and Lin 1995): near maximum likelihood.

The most reliable independent code bits are taken at their word, with every choice of up to two of them flipped;
the word that agrees best with all observations wins. With +-1 rows B of the reduced generator and the signed
reliabilities w of the first guess, the agreement after flips i, j is (B diag(w) B^T)_ij: one matrix product
tries all pairs. Further bases, drawn at random with reliable bits preferred, help where hard errors give no hint.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.polar import Bits
from meshmark.mesh import FloatArray

__all__ = ["Candidate", "ordered_statistics"]


class Candidate(NamedTuple):
    """Information bits (k,), and their agreement: the sum of the LLRs, each with the sign the word predicts."""

    bits: Bits
    agreement: float


def ordered_statistics(
    generator: Bits, llr: FloatArray, bases: int = 1, seed: int = 0
) -> Iterator[Candidate]:
    """Yield the best candidate of each of `bases` bases; nothing when the observed bits do not determine a word.

    generator: (k, n) uint8; llr: (n,), positive where a code bit is more likely 0, 0 where it was not observed.
    The first basis is the most reliable one, the others are random, the same for the same seed.
    """
    observed = np.flatnonzero(llr)
    if len(observed) < len(generator):
        return
    values, columns = llr[observed], generator[:, observed]
    log_weight = np.log(np.abs(values))
    rng = np.random.default_rng(seed)
    for basis in range(bases):
        noise = rng.gumbel(size=len(values)) if basis else rng.random(len(values)) * 1e-9
        order = np.argsort(-(log_weight + noise), kind="stable")
        reduced = _systematic(columns[:, order])
        if reduced is None:
            return
        yield _best_word(*reduced, values[order])


def _systematic(columns: Bits) -> tuple[Bits, Bits, list[int]] | None:
    """Reduce to the identity on the first independent columns: rows, their information bits, pivot columns.

    A row is one Python integer, its first column the highest bit, the information bits that make it the lowest.
    """
    k, n = columns.shape
    packed = np.packbits(np.hstack([columns, np.eye(k, dtype=np.uint8)]), axis=1)
    padding = 8 * packed.shape[1] - n - k
    rows = [int.from_bytes(row.tobytes(), "big") >> padding for row in packed]
    for step in range(k):
        lead = max(range(step, k), key=rows.__getitem__)
        pivot = rows[lead]
        if pivot < 1 << k:
            return None
        rows[lead] = rows[step]
        top = 1 << (pivot.bit_length() - 1)
        rows = [row ^ pivot if row & top else row for row in rows]
        rows[step] = pivot
    pivots = [n + k - row.bit_length() for row in rows]
    size = -(-(n + k) // 8)
    data = b"".join((row << padding).to_bytes(size, "big") for row in rows)
    full = np.unpackbits(np.frombuffer(data, dtype=np.uint8).reshape(k, size), axis=1, count=n + k)
    return full[:, :n], full[:, n:], pivots


def _best_word(rows: Bits, information: Bits, pivots: list[int], values: FloatArray) -> Candidate:
    chosen = values[pivots] < 0
    signs = 1.0 - 2.0 * rows
    weights = values * np.prod(signs[chosen], axis=0)
    single = signs @ weights
    pairs: NDArray[np.float64] = (signs * weights) @ signs.T
    np.fill_diagonal(pairs, single)
    best = np.unravel_index(np.argmax(pairs), pairs.shape)
    if weights.sum() < pairs[best]:
        for flip in {int(best[0]), int(best[1])}:
            chosen[flip] ^= True
    bits = np.asarray(np.bitwise_xor.reduce(information[chosen], axis=0))
    return Candidate(bits, float(max(weights.sum(), pairs[best])))
