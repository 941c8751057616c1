"""Clusters of points, checked by what defines them."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.areas import vertex_areas
from meshmark.research.schemes.clusters import fuzzy_c_means_regions, k_means_regions, memberships
from meshmark.segmentation.power_diagram import CONDENSED
from tests.counting import some
from tests.shapes import pebble

POINTS, FACES = pebble()
SEEDS = np.linspace(0, len(POINTS) - 1, 7).astype(np.int64)


def centroids(region, areas):
    return np.stack([np.average(POINTS[region == i], axis=0, weights=areas[region == i]) for i in range(7)])


def test_every_point_is_nearest_to_the_centroid_of_its_cluster():
    found = k_means_regions(POINTS, FACES, SEEDS)
    centres = centroids(found.region, vertex_areas(POINTS, FACES))
    distance = np.linalg.norm(POINTS[:, None] - centres, axis=2)
    own = np.take_along_axis(distance, found.region[:, None], axis=1)[:, 0]
    assert (own - distance.min(axis=1)).max() < 0.01 * np.ptp(POINTS)
    assert np.mean(distance.argmin(axis=1) == found.region) > 0.99


@pytest.mark.parametrize("cluster", [k_means_regions, fuzzy_c_means_regions])
def test_shares_are_those_of_the_halves(cluster):
    found = cluster(POINTS, FACES, SEEDS)
    areas = vertex_areas(POINTS, FACES)
    for half, shares in ((found.green, found.green_share), (~found.green, found.blue_share)):
        for i, share in some(enumerate(shares)):
            assert share == pytest.approx(areas[half & (found.region == i)].sum() / areas[half].sum())
    assert set(found.region) == set(range(7))


@pytest.mark.parametrize("cluster", [k_means_regions, fuzzy_c_means_regions])
def test_clusters_that_lie_apart_are_found_from_any_seed_in_each(cluster):
    rng = np.random.default_rng(4)
    where = np.repeat([[0.0, 0, 0], [9, 0, 0], [0, 9, 0]], 40, axis=0)
    points = where + rng.normal(size=where.shape)
    faces = np.stack([np.arange(118), np.arange(118) + 1, np.arange(118) + 2], axis=1)
    found = cluster(points, faces, np.array([5, 45, 85]))
    assert np.array_equal(found.region, np.repeat([0, 1, 2], 40))


@pytest.mark.parametrize("cluster", [k_means_regions, fuzzy_c_means_regions])
@pytest.mark.parametrize("across", [72, 130], ids=["each point for itself", "points in groups first"])
def test_turning_moving_and_resizing_change_nothing(cluster, across):
    points, faces = pebble(across)
    assert (len(points) > CONDENSED) == (across == 130)
    turn = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    seeds = np.linspace(0, len(points) - 1, 7).astype(np.int64)
    one, other = cluster(points, faces, seeds), cluster(points @ turn * 5.0 + 2.0, faces, seeds)
    assert np.mean(one.region == other.region) > 0.9999
    assert np.mean(one.green == other.green) > 0.9999


def test_memberships_are_bezdeks():
    rng = np.random.default_rng(1)
    points, centres = rng.normal(size=(20, 3)), rng.normal(size=(4, 3))
    plain = [
        [1.0 / sum((np.linalg.norm(x - c) / np.linalg.norm(x - d)) ** 2 for d in centres) for c in centres]
        for x in points
    ]
    assert memberships(points, centres) == pytest.approx(np.array(plain), rel=1e-9)


def test_a_point_on_a_centre_belongs_to_it_alone():
    centres = np.array([[0.0, 0, 0], [1, 0, 0], [5, 5, 5]])
    assert memberships(centres, centres) == pytest.approx(np.eye(3))
