"""Which copies a fingerprint is of: one, two that were combined, or a combination that no id explains."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import log2, log10

import numpy as np

from meshmark.coding.codec import Codec
from meshmark.coding.keyed_code import LENGTH, log10_chance
from meshmark.coding.message import ID_BITS, bits_of
from meshmark.coding.polar import Bits
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.carriers.quantisation import phase_noise, wrapped_normal
from meshmark.ownership.decoding import Listed
from meshmark.ownership.fingerprint.fingerprint_reading import FingerprintReading
from meshmark.ownership.fingerprint.parameters import CONTRADICTED, NAMED, SURE_DEVIATIONS
from meshmark.ownership.parameters import PROVEN_LOG10

__all__ = ["Told", "copies_told"]


@dataclass(frozen=True, kw_only=True)
class Told:
    """What a fingerprint tells.

    ids: of one copy, or of several that were combined, in rising order; none where `combined`: what is there is the
    word of an id that the witnesses contradict, so that several copies were put together. log10_chances: bounds on
    the chances that something else tells each id, over all that is compared with one reading.
    """

    ids: tuple[int, ...]
    log10_chances: tuple[float, ...]
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


# How a coordinate looks whose bits differ in two copies: half-way, as in their mean; as in either, as in the least
# of both along an axis of the file; or anyhow, along others.
_DIFFERING: tuple[Callable[[_Noise, FloatArray], FloatArray], ...] = (
    lambda noise, phase: noise.log_density(phase, 0.5 * np.pi, -0.5 * np.pi),
    lambda noise, phase: noise.log_density(phase, 0.0, np.pi),
    lambda _, phase: np.zeros_like(phase),
)


# Words that are looked for in one reading, and a list, twice.
_COMPARED = 4.0 + 2.0 * len(_DIFFERING)
# Of a list the words that agree best are compared by witnesses as well.
_LIKELIEST = 64


def copies_told(codec: Codec, reading: FingerprintReading, listed: Listed) -> Told | None:
    """Return what a reading tells, None where its words are not clear enough."""
    seen = _Seen.of(reading)
    candidates = _listed_words(codec, seen, listed) | _words(codec, seen)
    if not candidates:
        return None
    chances = {}
    unsure = False
    for each, chance in candidates.items():
        expected = seen.more * _deviations(seen.llr, codec.encode(each))
        said = _deviations(seen.witness, codec.witness(each))
        sure = expected >= SURE_DEVIATIONS
        unsure |= not sure
        # Of a listed id its word is enough: no sum of words is one but by the chance that is bounded.
        if said >= CONTRADICTED * expected and (sure or each in listed.ids):
            chances[each] = chance + log10(_COMPARED)
    if chances:
        ids = tuple(sorted(chances))
        return Told(ids=ids, log10_chances=tuple(chances[each] for each in ids))
    return None if unsure else Told(ids=(), log10_chances=(), combined=True)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Seen:
    """What the coordinates show of each code bit (LENGTH,), 0 where none has it.

    zero, one: log-likelihoods of the bits, over those of any phase; differ: for each of `_DIFFERING` that the bits
    differ; soft: sum of cosines, which averages of many copies are judged by; witness: ratio of the likelihoods of
    witnesses; soft_witness: sum of their cosines.
    more: standard deviations by which witnesses stand out, over those of the others.
    """

    zero: FloatArray
    one: FloatArray
    differ: tuple[FloatArray, ...]
    soft: FloatArray
    soft_witness: FloatArray
    witness: FloatArray
    more: float

    @classmethod
    def of(cls, reading: FingerprintReading) -> _Seen:
        keys = reading.keys
        noise = _Noise(*phase_noise(reading.phase[keys.pilot]))
        index, phase = keys.code_index[~keys.pilot], reading.phase[~keys.pilot]
        other, said = reading.witness_index, reading.witness_phase
        return cls(
            zero=_summed(index, noise.log_density(phase, 0.0)),
            one=_summed(index, noise.log_density(phase, np.pi)),
            differ=tuple(_summed(index, differing(noise, phase)) for differing in _DIFFERING),
            soft=_summed(index, np.cos(phase)),
            soft_witness=_summed(other, np.cos(said)),
            witness=_summed(other, noise.log_density(said, 0.0) - noise.log_density(said, np.pi)),
            more=float(np.sqrt(len(said) / max(len(phase), 1))),
        )

    @property
    def llr(self) -> FloatArray:
        """Log-likelihood ratios of the bits (LENGTH,)."""
        return self.zero - self.one

    def differing(self, bits: Bits) -> Iterator[FloatArray]:
        """Yield log-likelihood ratios (LENGTH,) of same over different bits in a copy beside one."""
        same = np.where(bits == 1, self.one, self.zero)
        for differ in self.differ:
            yield same - differ


def _words(codec: Codec, seen: _Seen) -> dict[int, float]:
    """Return the ids that stand out, with log10 of their chances: one, and those of copies beside it."""
    found: dict[int, float] = {}
    for observed in (seen.llr, seen.soft):
        word = codec.decode(observed, NAMED)
        if word.id is not None:
            found.setdefault(word.id, word.log10_chance)
    for first, own in list(found.items()):
        for differ in seen.differing(codec.encode(first)):
            other, chance = codec.decode_other(first, differ)
            if chance <= NAMED:
                found.setdefault(other, max(own, chance))
    return found


def _listed_words(codec: Codec, seen: _Seen, listed: Listed) -> dict[int, float]:
    """Return those of the listed ids that stand out, with log10 of their chances.

    Of a listed id the witnesses are known as well as the word. Cosines tell most of averages and medians of many
    copies, likelihoods of the least and largest coordinates, of which those are clear on which all copies agree.
    """
    found: dict[int, float] = {}
    if not listed.ids:
        return found
    for word, witness in ((seen.llr, seen.witness), (seen.soft, seen.soft_witness)):
        likeliest = np.argsort(-listed.words.agreement(word), kind="stable")[:_LIKELIEST]
        both = np.append(word, witness)
        for row in likeliest:
            each = listed.ids[row]
            if bits_of(each) != ID_BITS:
                continue
            agreement = both @ (1.0 - 2.0 * np.append(codec.encode(each), codec.witness(each)))
            chance = log10_chance(both, float(agreement), log2(len(listed.ids)))
            if chance <= PROVEN_LOG10:
                found[each] = min(chance, found.get(each, 0.0))
    return found


def _summed(index: IntArray, values: FloatArray) -> FloatArray:
    return np.bincount(index, values, LENGTH).astype(np.float64)


def _deviations(llr: FloatArray, bits: Bits) -> float:
    """Return by how many standard deviations of chance observations (n,) agree with bits (n,)."""
    return float(llr @ (1.0 - 2.0 * bits) / np.sqrt(max(float(llr @ llr), 1e-300)))
