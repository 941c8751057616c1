"""Bounds in words and in numbers: none is below that of guessing the key."""

from __future__ import annotations

import math

import pytest

from meshmark.coding.chance import BANDS, band, believable, in_words
from meshmark.coding.keys import KEY_BYTES, LOG10_GUESS


def test_a_guess_hits_one_key_of_all():
    assert math.isclose(10.0**-LOG10_GUESS, 2 ** (8 * KEY_BYTES), rel_tol=1e-9)


@pytest.mark.parametrize(
    ("bound", "number", "words"),
    [
        (0.0, 0.0, "below 10^0"),
        (-9.0, -9.0, "below 10^-9"),
        (-142.0, LOG10_GUESS, "below 10^-77, that of guessing the key"),
        (-6856.0, LOG10_GUESS, "below 10^-77, that of guessing the key"),
        (-77.0, -77.0, "below 10^-77"),
        (-12.7, -12.7, "below 10^-12"),
    ],
)
def test_bounds(bound, number, words):
    assert believable(bound) == number
    assert in_words(bound) == words, "rounded towards the worse"


@pytest.mark.parametrize(
    ("bound", "said"),
    [
        (0.0, 0.0),
        (-5.99, 0.0),
        (-6.0, -6.0),
        (-11.9, -6.0),
        (-12.0, -12.0),
        (-29.0, -12.0),
        (-30.0, -30.0),
        (-77.0, -30.0),
    ],
)
def test_bands_are_no_better_than_the_bound(bound, said):
    assert band(bound) == said
    assert said >= bound


def test_bands_are_from_best_to_worst():
    assert sorted(BANDS) == list(BANDS)
