"""How visible a change is."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.visibility import VisibleChange
from tests.shapes import pebble

POINTS, FACES = pebble(72)
NORMALS = vertex_normals(POINTS, FACES)
SIZE = np.linalg.norm(np.ptp(POINTS, axis=0))


def waves(height: float, number: float) -> np.ndarray:
    """Return a displacement (p,) of this height over the diagonal, of so many waves over it."""
    return height * SIZE * np.sin(2 * np.pi * number / SIZE * POINTS @ [0.6, 0.64, 0.48])


def test_nothing_is_seen_where_nothing_changed_nor_after_a_shift():
    seen = VisibleChange(POINTS, FACES)
    for points in (POINTS, POINTS + 3.0):
        found = seen.of(points)
        assert found.share == 0.0
        assert found.p95 < 1e-5


def test_a_wave_is_seen_by_its_slope_not_by_its_height():
    seen = VisibleChange(POINTS, FACES)
    gentle = seen.of(POINTS + waves(1e-3, 1)[:, None] * NORMALS)
    steep = seen.of(POINTS + waves(5e-4, 20)[:, None] * NORMALS)
    assert gentle.share < 0.05
    assert steep.share > 0.3
    assert steep.median > 2.0 * gentle.median


def test_points_that_are_seen_lie_where_the_surface_changed():
    seen = VisibleChange(POINTS, FACES)
    right = POINTS[:, 0] > np.median(POINTS[:, 0])
    found = seen.seen(POINTS + (waves(5e-4, 20) * right)[:, None] * NORMALS)
    assert found[right].mean() > 0.3
    assert found[~right].mean() < 0.15
    assert not seen.seen(POINTS + 3.0).any()


def test_rough_surface_hides_what_shows_on_a_smooth_one():
    noise = 2e-3 * SIZE * np.random.default_rng(1).normal(size=POINTS.shape)
    change = waves(2e-4, 15)[:, None] * NORMALS
    smooth = VisibleChange(POINTS, FACES).of(POINTS + change)
    rough = VisibleChange(POINTS + noise, FACES).of(POINTS + noise + change)
    assert rough.median < 0.7 * smooth.median


def test_the_first_order_predicts_small_changes():
    seen = VisibleChange(POINTS, FACES)
    length = waves(1e-5, 12)
    ratio = seen.ratios_of(seen.slopes(NORMALS) @ length)
    exact = seen.of(POINTS + length[:, None] * NORMALS)
    assert np.median(ratio) == pytest.approx(exact.median, rel=0.01)
    assert np.quantile(ratio, 0.95) == pytest.approx(exact.p95, rel=0.01)


def test_size_place_and_unit_make_no_difference():
    change = waves(2e-4, 12)[:, None] * NORMALS
    one = VisibleChange(POINTS, FACES).of(POINTS + change)
    other = VisibleChange(1e-3 * POINTS + 7.0, FACES).of(1e-3 * (POINTS + change) + 7.0)
    assert other.median == pytest.approx(one.median, rel=1e-3)
    assert other.share == pytest.approx(one.share, abs=0.01)


def doubled(points, faces):
    """Return faces that are there twice, once facing each way."""
    return np.concatenate([faces, faces[:, ::-1]])


def test_doubled_faces_have_no_normals_that_could_change():
    points, faces = pebble(24)
    other, sheet = pebble(20)
    both = np.concatenate([points, 0.3 * other + [4.0, 0.0, 0.0]])
    more = np.concatenate([faces, doubled(other, sheet) + len(points)])
    seen = VisibleChange(both, more)
    rough = 0.02 * np.random.default_rng(3).normal(size=both.shape)
    on_doubled = np.arange(len(both)) >= len(points)
    moved = seen.of(both + np.where(on_doubled[:, None], rough, 0.0))
    assert (moved.share, moved.median) == (0.0, pytest.approx(0.0, abs=1e-5))
    assert seen.of(both + np.where(on_doubled[:, None], 0.0, rough)).share > 0.5
    # No patch lies around a point that says nothing.
    assert (seen.centres < len(points)).all()


def test_a_surface_that_is_doubled_everywhere_is_judged_without_complaint():
    points, faces = pebble(24)
    seen = VisibleChange(points, doubled(points, faces))
    found = seen.of(points + 0.01 * np.random.default_rng(4).normal(size=points.shape))
    assert found.share == 0.0
    assert np.isfinite([found.median, found.p95, found.smooth]).all()
    assert np.isfinite(seen.noticed).all()
