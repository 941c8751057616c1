"""Norms in bins: what the mark of Cho, Prost and Jung moves, and what stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from meshmark.coding.keys import Key
from meshmark.mesh import Mesh
from meshmark.research.schemes.rivals.cho import ChoMean, norm_margins, shifted_norms
from meshmark.research.schemes.rivals.histogram import MEAN, VARIANCE, bins_of, raised, within
from tests.counting import Share
from tests.shapes import pebble

KEY = Key(b"h" * 32)
COUNT = 8


def norms(seed, size=4000):
    return np.random.default_rng(seed).uniform(1.0, 3.0, size)


def code_of(seed):
    return np.random.default_rng(seed).integers(0, 2, COUNT).astype(np.uint8)


def test_bins_are_equal_and_hold_every_norm_between_their_ends():
    with Share(0.3) as share:
        are_equal_bins(share)


@given(hnp.arrays(float, st.integers(1, 60), elements=st.floats(0.0, 1e3)), st.integers(1, 9))
def are_equal_bins(share, values, count):
    bins = bins_of(values, count)
    assert bins.count.sum() == len(values)
    assert np.allclose(bins.norms(bins.x), values, rtol=1e-12, atol=1e-9)
    # numpy refuses bins that are narrower than the numbers are apart.
    spread = np.ptp(values) > max(1e-6 * values.max(), 1e-290)
    expected = np.histogram(values, count)[0] if spread else None
    share.case()
    if expected is not None:  # a norm on an edge may round to either side
        share.asserted()
        assert np.abs(np.cumsum(bins.count) - np.cumsum(expected)).max() <= count


@pytest.mark.parametrize("statistic", [MEAN, VARIANCE])
@pytest.mark.parametrize("margin", [0.01, 0.1])
def test_each_bin_reaches_its_margin_and_no_further_than_a_step_needs(statistic, margin):
    bins, code = bins_of(norms(1), COUNT), code_of(2)
    after = bins_of(raised(bins, code, statistic, margin), COUNT)
    reached = after.margins(statistic) * (2.0 * code - 1.0)
    already = np.maximum(bins.margins(statistic) * (2.0 * code - 1.0), margin)
    assert (reached >= margin - 1e-9).all()
    assert (reached <= already + 0.001).all()


def test_the_exponent_of_a_uniform_bin_is_the_papers():
    """The mean of x^k over [0, 1] is 1 / (k + 1): k = (1 - 2a) / (1 + 2a) gives 1/2 + a."""
    x = np.linspace(0.0, 1.0, 200_001)
    moved = raised(bins_of(x, 1), np.ones(1, np.uint8), MEAN, 0.05)
    assert np.allclose(moved, x ** (0.9 / 1.1), atol=0.001)


@pytest.mark.parametrize("statistic", [MEAN, VARIANCE])
def test_ends_of_bins_stay_and_no_norm_overtakes_another(statistic):
    values = norms(3)
    bins = bins_of(values, COUNT)
    moved = raised(bins, code_of(4), statistic, 0.1)
    order = np.argsort(values)
    assert (np.diff(moved[order]) >= -1e-12).all()
    after = bins_of(moved, COUNT)
    assert np.array_equal(after.count, bins.count)
    assert np.allclose(after.low, bins.low)
    assert np.allclose(after.width, bins.width)


def test_what_lies_within_the_trimmed_ends_is_the_same_after_marking():
    values = norms(5)
    inside = within(values, 0.02)
    assert inside.sum() == len(values) - 2 * int(0.02 * len(values))
    moved = values.copy()
    moved[inside] = raised(bins_of(values[inside], COUNT), code_of(6), MEAN, 0.2)
    assert np.array_equal(within(moved, 0.02), inside)


def test_points_move_along_their_norms_about_the_centre_they_have_afterwards():
    points, code = pebble(40)[0] * [0.6, 0.9, 1.5], code_of(7)
    placed = shifted_norms(points, code, MEAN, 0.1)
    centre = placed.mean(axis=0)
    assert np.abs(np.cross(points - centre, placed - centre)).max() < 1e-9
    assert (norm_margins(placed, COUNT, MEAN) * (2.0 * code - 1.0) >= 0.1 - 1e-6).all()


def test_more_noise_breaks_more_bits_and_a_similarity_none():
    points, faces = pebble(90)
    host = Mesh(points * [0.6, 0.9, 1.5], faces)
    bits = np.random.default_rng(8).integers(0, 2, 64).astype(np.uint8)
    marked = ChoMean(pilots=0).marked(host, bits, KEY, 8e-4)
    turn = np.linalg.qr(np.random.default_rng(9).normal(size=(3, 3)))[0]
    turned = marked.with_vertices(7.0 * marked.vertices @ turn + [1.0, -2.0, 3.0])
    assert np.array_equal(ChoMean(pilots=0).extract(turned, KEY).bits, bits)
    noise = np.random.default_rng(10).uniform(-1.0, 1.0, host.vertices.shape)
    wrong = [
        np.mean(
            ChoMean(pilots=0).extract(marked.with_vertices(marked.vertices + a * noise), KEY).bits != bits
        )
        for a in (0.0, 0.003, 0.03)
    ]
    assert wrong[0] == 0.0 < wrong[1] < 0.35 < wrong[2]
