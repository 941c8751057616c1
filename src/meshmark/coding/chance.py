"""Bounds on the chance of a false alarm, as they can be believed: none is below that of guessing the key.

Whoever guesses the key of 256 bits, with a chance of 2^-256 or about 10^-77, makes marks that no reader can tell
from the owner's. So what is read from a model, however improbable without the key, proves no more than that.
"""

from __future__ import annotations

from math import ceil
from typing import Final

from meshmark.coding.keys import LOG10_GUESS

__all__ = ["BANDS", "band", "believable", "in_words"]

BANDS: Final = (-30.0, -12.0, -6.0)
"""Bounds that an answer to strangers tells apart (log10); any better one is said to be the lowest."""


def believable(log10_chance: float) -> float:
    """Return log10 of a bound on a chance, at least that of guessing the key."""
    return max(log10_chance, LOG10_GUESS)


def band(log10_chance: float) -> float:
    """Return the lowest of `BANDS` that a bound is not above, 0 above all of them.

    An exact bound tells whoever edits a model how near the mark is to be gone, edit by edit.
    """
    return next((limit for limit in BANDS if log10_chance <= limit), 0.0)


def in_words(log10_chance: float) -> str:
    """Return a bound in words, rounded up: "below 10^-12"; "below 10^-77, that of guessing the key"."""
    words = f"below 10^{ceil(believable(log10_chance))}"
    return f"{words}, that of guessing the key" if log10_chance <= LOG10_GUESS else words
