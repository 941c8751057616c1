"""The visible energy of displacements."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.areas import vertex_areas, vertex_normals
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.visibility import VisibleChange
from meshmark.ownership.bumps import frame_gradient
from meshmark.ownership.visible_energy import DECAY, LEAST_AREA, visible_energy
from tests.shapes import pebble

SPACING = 0.25


def energy_of(points, faces):
    """Return the matrix (p, p), and the canonical points."""
    points = canonical_frame(points, faces).to_canonical(points)
    placed = points / SPACING
    gradient = frame_gradient(points, faces, vertex_normals(points, faces))
    seen = VisibleChange(points, faces)
    return visible_energy(placed, faces, vertex_areas(placed, faces), gradient, seen), points


def test_moving_all_points_alike_costs_their_area():
    points, faces = pebble(72)
    energy, points = energy_of(points, faces)
    areas = vertex_areas(points / SPACING, faces)
    everywhere = np.ones(len(points))
    # Small vertices count a little more, and the mask has a mean of 1.
    assert everywhere @ energy @ everywhere == pytest.approx(DECAY * areas.sum(), rel=0.1)


def test_the_energy_is_a_positive_definite_form():
    energy, _ = energy_of(*pebble(20))
    dense = energy.toarray()
    np.testing.assert_allclose(dense, dense.T, atol=1e-12 * np.abs(dense).max())
    assert np.linalg.eigvalsh(dense).min() > 0.0


def test_steeper_waves_of_one_height_are_more_visible():
    energy, points = energy_of(*pebble(72))
    waves = [np.sin(number * points @ [1.0, 0.7, -0.4]) for number in (2.0, 14.0)]
    gentle, steep = (wave @ energy @ wave for wave in waves)
    assert steep > 2.0 * gentle


def test_a_wave_costs_less_on_the_rough_half_of_a_surface():
    points, faces = pebble(96)
    heights = points[:, 2]
    rough = heights > 0.0
    noise = np.random.default_rng(1).normal(size=points.shape)
    energy, points = energy_of(points + 0.004 * rough[:, None] * noise, faces)
    wave = np.sin(6.0 * points @ [1.0, 0.7, -0.4])
    areas = vertex_areas(points, faces)
    sides = [np.clip(6.0 * height, 0.0, 1.0) for height in (heights - 0.2, -0.2 - heights)]
    here, there = ((wave * side) @ energy @ (wave * side) / (areas @ side) for side in sides)
    assert here < 0.5 * there


def test_points_without_area_do_not_make_it_singular():
    points, faces = pebble(20)
    energy, _ = energy_of(np.concatenate([points, points[:1]]), faces)
    assert (energy.diagonal() >= DECAY * LEAST_AREA * 1e-3).all()
