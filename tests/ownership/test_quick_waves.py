"""Cosines in single precision, of angles of many turns."""

from __future__ import annotations

import numpy as np

from meshmark.ownership.quick_waves import quick_cosine, quick_wave


def test_many_turns_lose_nothing():
    turns = np.random.default_rng(0).uniform(-1e6, 1e6, (50, 40))
    angle = 2.0 * np.pi * (turns - np.rint(turns))
    cosine, sine = quick_wave(turns)
    assert cosine.dtype == sine.dtype == np.float32
    np.testing.assert_allclose(cosine, np.cos(angle), atol=1e-6)
    np.testing.assert_allclose(sine, np.sin(angle), atol=1e-6)
    np.testing.assert_array_equal(quick_cosine(turns), cosine)
