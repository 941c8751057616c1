"""Shares screened at once are what each is by itself."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.ownership.points.lock_chance import log10_loose_chance
from meshmark.ownership.points.screened_shares import ScreenedShares
from tests.counting import some

CUTS = (1.0, 0.5, 0.25, 0.125)


@pytest.fixture
def drawn():
    """Coordinates in the order of their draws, in groups of about three with one draw each."""
    rng = np.random.default_rng(4)
    group = rng.integers(0, 100, 300)
    draw = rng.random(100)[group]
    order = np.argsort(draw, kind="stable")
    return draw[order], group[order], rng.random(300) < 0.7, rng.uniform(0.0, 2.0 * np.pi, 300)


def test_each_share_has_its_own_chance(drawn):
    draw, group, carries, angle = drawn
    found = ScreenedShares.of(carries, draw, group, CUTS, 10).log10_chances(np.cos(angle), np.sin(angle))
    assert len(found) == len(CUTS)
    for cut, chance in some(list(zip(CUTS, found, strict=True))):
        kept = carries & (draw < cut)
        wave = np.array([np.exp(1j * angle[kept & (group == each)]).sum() for each in range(100)])
        assert chance == pytest.approx(log10_loose_chance(wave.real.sum(), (np.abs(wave) ** 2).sum()))


def test_shares_with_too_few_coordinates_are_left_out(drawn):
    draw, group, carries, angle = drawn
    counts = [int((carries & (draw < cut)).sum()) for cut in CUTS]
    for least, expected in ((counts[1], 2), (counts[1] + 1, 1), (counts[0] + 1, 0)):
        shares = ScreenedShares.of(carries, draw, group, CUTS, least)
        assert len(shares.log10_chances(np.cos(angle), np.sin(angle))) == expected


def test_no_coordinate_has_no_share():
    none = np.zeros(0)
    shares = ScreenedShares.of(np.zeros(0, bool), none, np.zeros(0, np.int64), CUTS, 10)
    assert shares.log10_chances(none, none) == []
