"""Frames before a crop: the true one is close to one of the first."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from meshmark.geometry.completion import completed_frames, frame_distance
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.invariants import sampled_invariants, shape_invariants
from meshmark.geometry.sampling import plan_samples
from tests.counting import some
from tests.shapes import pebble


def cropped(share, seed):
    points, faces = pebble(60)
    normal = np.random.default_rng(seed).normal(size=3)
    height = points @ (normal / np.linalg.norm(normal))
    keep = height < np.quantile(height, 1.0 - share)
    return points, faces, faces[keep[faces].all(axis=1)]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("share", [0.03, 0.09])
def test_the_frame_of_the_whole_is_among_the_first(share, seed):
    points, faces, part = cropped(share, seed)
    whole, now = canonical_frame(points, faces), canonical_frame(points, part)
    frames = [whole.frame for whole in completed_frames(points, part, 0.035, 100)]
    nearest = min(frame_distance(frame, whole) for frame in frames)
    assert nearest < 0.1
    assert nearest < 0.6 * frame_distance(now, whole)


def test_frames_are_apart_and_rotations():
    points, _, part = cropped(0.06, 1)
    frames = [whole.frame for whole in completed_frames(points, part, 0.05, 30)]
    assert 5 < len(frames) <= 30
    for frame in some(frames):
        np.testing.assert_allclose(frame.axes.T @ frame.axes, np.eye(3), atol=1e-9)
        assert np.linalg.det(frame.axes) == pytest.approx(1.0)
        assert frame.moments.sum() == pytest.approx(1.0)
    assert all(frame_distance(one, other) > 0.045 for other, one in some(combinations(frames, 2)))


@pytest.mark.parametrize("share", [0.03, 0.09])
def test_with_its_cap_the_part_is_shaped_as_the_whole(share):
    """The invariants of the best of the first frames are nearer to those of the whole than the part's own are."""
    points, faces, part = cropped(share, 2)
    frame = canonical_frame(points, faces)
    whole, now = shape_invariants(points, faces, frame), shape_invariants(points, part)
    best = np.inf
    for each in some(completed_frames(points, part, 0.035, 12)):
        assert each.area > 0.0
        samples = plan_samples(points, part, 0.1 * frame.scale)(points)
        places = each.frame.to_canonical(np.concatenate([samples.positions, each.places]))
        areas = np.concatenate([samples.areas, np.full(len(each.places), each.area / len(each.places))])
        completed = sampled_invariants(places, areas, each.frame)
        best = min(best, float(np.abs(completed - whole).max()))
    assert best < 0.5 * np.abs(now - whole).max()


def test_a_closed_surface_has_none():
    assert completed_frames(*pebble(20), 0.035, 10) == []


def test_the_distance_is_the_motion_of_the_surface():
    points, faces = pebble(40)
    one = canonical_frame(points, faces)
    assert frame_distance(one, one) == pytest.approx(0.0, abs=1e-7)
    shifted = replace(one, centre=one.centre + one.axes @ np.array([0.01, 0.0, 0.0]) * one.scale)
    assert frame_distance(shifted, one) == pytest.approx(0.01)
    grown = replace(one, scale=one.scale * 1.02)
    assert frame_distance(grown, one) == pytest.approx(np.log(1.02))
    angle = 0.03
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
    # Over a round shape a turn moves points by sqrt(2 / 3) of its angle times the radius.
    assert frame_distance(replace(one, axes=one.axes @ turn), one) == pytest.approx(
        angle * np.sqrt(0.67), rel=1e-3
    )
