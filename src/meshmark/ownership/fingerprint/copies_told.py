"""Which copies a fingerprint is of: one, two that were combined, or a combination that no id explains."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log, log10

import numpy as np

from meshmark.coding.codec import Codec
from meshmark.coding.keyed_code import LENGTH, log10_chance
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.quantisation import phase_noise, wrapped_normal
from meshmark.ownership.fingerprint.fingerprint_reading import FingerprintReading
from meshmark.ownership.fingerprint.parameters import CONTRADICTED, NAMED, SURE_DEVIATIONS

__all__ = ["Told", "copies_told"]


@dataclass(frozen=True, kw_only=True)
class Told:
    """What a fingerprint tells.

    ids: of one copy, or of two, in rising order; none where `combined`: what is there is the word of an id that the
    witnesses contradict, so that several copies were put together. log10_chance: bound on the chance that something
    else tells these ids, over all that is compared with one reading.
    """

    ids: tuple[int, ...]
    log10_chance: float
    combined: bool = False


@dataclass(frozen=True, eq=False)
class _Noise:
    """Noise of the phases, as the pilots have it: variance, and the share of broken ones, which have any phase."""

    variance: float
    broken: float

    def log_density(self, phase: FloatArray, *centres: float) -> FloatArray:
        """Return the logarithm of the density about centres that are equally likely, over that of any phase."""
        normal = np.mean([wrapped_normal(phase - centre, self.variance) for centre in centres], axis=0)
        return np.asarray(np.log((1.0 - self.broken) * 2.0 * np.pi * normal + self.broken))


# How a coordinate looks whose bits differ in two copies: half-way, as in their mean; as in either, as in the least of
# both along an axis of the file; or anyhow, along others.
_DIFFERING: tuple[Callable[[_Noise, FloatArray], FloatArray], ...] = (
    lambda noise, phase: noise.log_density(phase, 0.5 * np.pi, -0.5 * np.pi),
    lambda noise, phase: noise.log_density(phase, 0.0, np.pi),
    lambda noise, phase: np.zeros_like(phase),
)


def copies_told(codec: Codec, reading: FingerprintReading) -> Told | None:
    """Return what a reading tells, None where its words are not clear enough."""
    keys = reading.keys
    noise = _Noise(*phase_noise(reading.phase[keys.pilot]))
    index, phase = keys.code_index[~keys.pilot], reading.phase[~keys.pilot]
    says = [_summed(index, noise.log_density(phase, centre)) for centre in (0.0, np.pi)]
    llr = says[0] - says[1]
    first = codec.decode(llr, NAMED)
    if first.id is None:
        return None
    same = np.where(first.bits == 1, says[1], says[0])
    others = []
    for differing in _DIFFERING:
        differ = same - _summed(index, differing(noise, phase))
        others.append(codec.decode_other(first.id, differ))
    other, chance = min(others, key=lambda each: each[1])
    chance += log10(len(_DIFFERING))
    witness = _summed(
        reading.witness_index,
        noise.log_density(reading.witness_phase, 0.0) - noise.log_density(reading.witness_phase, np.pi),
    )
    expected = _deviations(llr, first.bits) * np.sqrt(len(reading.witness_phase) / max(len(phase), 1))
    if chance <= NAMED:
        ids = (min(first.id, other), max(first.id, other))
        chance = max(chance, first.log10_chance)
    else:
        ids, chance = (first.id,), first.log10_chance
    if expected < SURE_DEVIATIONS:
        return None
    if any(_deviations(witness, codec.witness(each)) < CONTRADICTED for each in ids):
        return Told(ids=(), log10_chance=0.0, combined=True)
    return Told(ids=ids, log10_chance=chance + log10(2.0))


def _summed(index: IntArray, values: FloatArray) -> FloatArray:
    return np.bincount(index, values, LENGTH).astype(np.float64)


def _deviations(llr: FloatArray, bits: np.ndarray) -> float:
    """Return by how many standard deviations of chance observations (n,) agree with bits (n,)."""
    return float(llr @ (1.0 - 2.0 * bits) / np.sqrt(max(float(llr @ llr), 1e-300)))
