"""How far the code is from what any code could do: `python -m claims.code [--trials N] [--design]`.

Success of decoding from N carriers, each showing a keyed random code bit: hard flips of a given share (every
carrier looks equally good), or soft values of the same share (binary input, Gaussian noise). Beside it stands
the ideal: a decoder that always finds the sent word and carriers that never share a code bit, under the same
bound on chance. Prints Markdown for docs/decisions/0004-code.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from meshmark.coding.codec import CHECK_WORD_LIMIT
from meshmark.coding.keyed_code import CHECKS, LENGTH, PATHS, log10_chance
from meshmark.coding.list_decoder import ListDecoder
from meshmark.coding.message import ID_BITS
from meshmark.coding.polar import polar_code

CARRIERS = (100, 110, 120, 130, 150, 200, 300, 500, 1000, 2000)
ERRORS = (0.0, 0.02, 0.05, 0.10, 0.15, 0.20, 0.25, 0.30, 0.35)
LIMITS = (-6.0, CHECK_WORD_LIMIT)
DESIGN_CHANNELS = (
    (110, 0.02, "hard"),
    (150, 0.08, "hard"),
    (300, 0.20, "hard"),
    (300, 0.25, "soft"),
    (1000, 0.35, "soft"),
)
SUBKEY = bytes(range(32))


class Channel(NamedTuple):
    """N carriers, the share of wrong hard decisions, and whether reliabilities are known ("soft")."""

    carriers: int
    error: float
    kind: str


class Score(NamedTuple):
    """Shares of trials, per limit: right id, ideal decoder, wrong id; and milliseconds per decoding."""

    right: NDArray[np.float64]
    ideal: NDArray[np.float64]
    wrong: NDArray[np.float64]
    milliseconds: float


def observations(channel: Channel, rng: np.random.Generator) -> NDArray[np.float64]:
    """LLRs up to a scale of carriers that all carry 0."""
    if channel.kind == "hard":
        return np.where(rng.random(channel.carriers) < channel.error, -1.0, 1.0)
    sigma = 1.0 / norm.isf(channel.error) if channel.error else 1e-3
    return 1.0 + sigma * rng.standard_normal(channel.carriers)


def measure(
    channel: Channel, trials: int, length: int, checks: int, paths: int, limits: tuple[float, ...]
) -> Score:
    code = polar_code(length, ID_BITS, checks, SUBKEY)
    decoder = ListDecoder(code)
    rng = np.random.default_rng(11)
    passes = np.array(limits)
    right, ideal, wrong, spent = np.zeros(len(limits)), np.zeros(len(limits)), np.zeros(len(limits)), 0.0
    for _ in range(trials):
        identity = int(rng.integers(2**63))
        values = observations(channel, rng)
        ideal += log10_chance(values, float(values.sum())) <= passes
        index = rng.integers(0, length, channel.carriers)
        llr = np.bincount(index, values * (1.0 - 2.0 * code.encode(identity)[index]), length)
        start = perf_counter()
        ids, words = decoder.decode(llr, paths)
        spent += perf_counter() - start
        agreement = llr.sum() - 2.0 * words @ llr
        best = int(np.argmax(agreement))
        passed = log10_chance(llr, float(agreement[best])) <= passes
        right += passed & (int(ids[best]) == identity)
        wrong += passed & (int(ids[best]) != identity)
    return Score(right / trials, ideal / trials, wrong / trials, 1e3 * spent / trials)


def success_tables(trials: int) -> Iterator[str]:
    """Right id in per cent, that of the ideal behind it, for both kinds and both limits."""
    for kind in ("hard", "soft"):
        scores = {
            (n, e): measure(Channel(n, e, kind), trials, LENGTH, CHECKS, PATHS, LIMITS)
            for n in CARRIERS
            for e in ERRORS
        }
        for which, limit in enumerate(LIMITS):
            yield f"\n{kind} errors, chance below 10^{limit:.1f}\n"
            yield "| carriers | " + " | ".join(f"{100 * e:.0f} %" for e in ERRORS) + " |"
            yield "|---" * (len(ERRORS) + 1) + "|"
            for n in CARRIERS:
                cells = (scores[n, e] for e in ERRORS)
                shown = (f"{100 * s.right[which]:.0f} / {100 * s.ideal[which]:.0f}" for s in cells)
                yield f"| {n} | " + " | ".join(shown) + " |"
        wrong = sum(float(s.wrong[0]) for s in scores.values()) * trials
        time = np.median([s.milliseconds for s in scores.values()])
        yield f"\nwrong ids: {wrong:.0f} of {trials * len(scores)}; median {time:.1f} ms per decoding"


def design_table(trials: int) -> Iterator[str]:
    """Right / wrong ids in per cent for other lengths, numbers of checks and lists, chance below 10^-6."""
    channels = " | ".join(f"{n}, {100 * e:.0f} % {k}" for n, e, k in DESIGN_CHANNELS)
    yield f"| length | checks | list | {channels} | time |"
    yield "|---" * (len(DESIGN_CHANNELS) + 4) + "|"
    rows = [(n, CHECKS, PATHS) for n in (512, 1024, 2048, 4096, 8192)]
    rows += [(LENGTH, c, PATHS) for c in (0, 8, 24, 32)] + [(LENGTH, CHECKS, p) for p in (8, 32, 128)]
    for length, checks, paths in rows:
        scores = [measure(Channel(*c), trials, length, checks, paths, LIMITS) for c in DESIGN_CHANNELS]
        shown = (f"{100 * s.right[0]:.1f} ({100 * s.wrong[0]:.2f})" for s in scores)
        time = np.mean([s.milliseconds for s in scores])
        yield f"| {length} | {checks} | {paths} | " + " | ".join(shown) + f" | {time:.1f} ms |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--design", action="store_true", help="compare designs instead")
    arguments = parser.parse_args()
    table = design_table if arguments.design else success_tables
    for line in table(arguments.trials):
        print(line, flush=True)


if __name__ == "__main__":
    main()
