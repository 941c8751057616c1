"""Eigenfunctions, salient spots and geodesic regions of the Laplace-Beltrami and diffusion schemes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csc_array, diags_array

from meshmark.errors import CapacityError
from meshmark.geometry.areas import vertex_areas
from meshmark.mesh import Mesh
from meshmark.research.schemes.rivals.adf import Adf
from meshmark.research.schemes.rivals.eigen import smallest_eigenpairs, surface_eigenpairs
from meshmark.research.schemes.rivals.fuzzy import fuzzy_c_means
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.laplace_beltrami import LaplaceBeltrami
from meshmark.research.schemes.rivals.voronoi import clusters, edge_lengths, regions
from tests.shapes import pebble, sphere_with_a_spike


def strip(count=6):
    """A flat band of squares, each of two triangles, 1 wide."""
    low = np.arange(count)
    points = np.concatenate(
        [np.column_stack([low, 0 * low, 0 * low]), np.column_stack([low, 0 * low + 1, 0 * low])]
    )
    a, b, c, d = low[:-1], low[1:], low[1:] + count, low[:-1] + count
    return Host(Mesh(points.astype(float), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])))


def test_eigenvalues_of_a_sphere_are_l_times_l_plus_1():
    points, faces, _ = sphere_with_a_spike(40)
    points /= np.linalg.norm(points, axis=1)[:, None]
    values, functions = surface_eigenpairs(points, faces, 8)
    assert values / (4.0 * np.pi) == pytest.approx(
        [2] * 3 + [6] * 5, rel=0.03
    )  # area 1 is radius^2 = 1 / 4 pi
    areas = vertex_areas(points, faces)
    products = functions.T @ (functions * (areas / areas.sum())[:, None])
    assert np.allclose(products, np.eye(8), atol=1e-6)


def test_eigenpairs_are_those_of_a_dense_solver_and_the_same_each_time():
    host = Host(Mesh(*pebble(16)))
    degree = diags_array(np.asarray(host.graph.sum(axis=1)))
    stiffness = csc_array(degree - host.graph)
    mass = np.linspace(0.5, 1.5, len(host.points)) / len(host.points)
    values, vectors = smallest_eigenpairs(stiffness, mass, 6)
    assert values == pytest.approx(eigh(stiffness.toarray(), np.diag(mass), eigvals_only=True)[:6], abs=1e-5)
    assert np.array_equal(smallest_eigenpairs(stiffness, mass, 6)[1], vectors)


def test_a_part_of_its_own_has_no_constant_among_its_functions():
    points, faces = pebble(16)
    two = np.concatenate([points, points + 9.0]), np.concatenate([faces, faces + len(points)])
    values, functions = surface_eigenpairs(*two, 6)
    assert (values > 1.0).all()
    assert np.ptp(functions[: len(points)], axis=0).max() > 0.1


def test_lengths_are_those_of_edges():
    host = strip()
    lengths = edge_lengths(host)
    rows, columns = lengths.nonzero()
    assert np.allclose(lengths.data, np.linalg.norm(host.points[rows] - host.points[columns], axis=1))


def test_clusters_take_what_is_near_and_rank_by_their_total():
    votes = np.zeros(12)
    votes[[0, 1, 5]] = 2.0, 1.5, 3.0
    rows, sums = clusters(edge_lengths(strip()), votes, 1.5, lambda part: float(part.sum()))
    assert np.array_equal(sums, [3.5, 3.0])
    assert rows[[0, 1, 5]].tolist() == [0, 0, 1]
    assert (np.delete(rows, [0, 1, 5]) == -1).all()


def test_regions_are_the_nearest_cluster_along_edges_and_through_space_elsewhere():
    host = strip()
    cluster = np.full(12, -1)
    cluster[[0, 5]] = 0, 1
    assert regions(host, edge_lengths(host), cluster).tolist() == [0, 0, 0, 1, 1, 1] * 2
    points, faces = np.array(host.points), host.faces
    apart = Host(
        Mesh(np.concatenate([points, points + np.array([30.0, 0, 0])]), np.concatenate([faces, faces + 12]))
    )
    cluster = np.append(cluster, np.full(12, -1))
    assert (regions(apart, edge_lengths(apart), cluster)[12:] == 1).all()


@pytest.mark.parametrize("scheme", [LaplaceBeltrami(), Adf()])
def test_regions_do_not_depend_on_place_size_or_turn(scheme):
    points, faces = pebble(50)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    found = scheme.regions(Host(Mesh(points, faces)))
    moved = scheme.regions(Host(Mesh(40.0 * points @ turn + [1.0, 2.0, 3.0], faces)))
    assert np.mean(found == moved) > 0.99  # paths of equal length may go either way
    assert scheme.least <= len(np.unique(found)) <= scheme.most


def test_a_tip_is_where_the_diffusion_stays():
    points, faces = pebble(50)
    peak = np.argmax(Adf().votes(Host(Mesh(points * [3.0, 1.0, 1.0], faces))))
    assert (
        np.mean(np.abs(points[:, 0] - np.mean(points[:, 0])) > abs(points[peak, 0] - np.mean(points[:, 0])))
        < 0.1
    )


def test_a_model_without_salient_points_is_refused():
    flat = Host(
        Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]), np.array([[0, 1, 2], [1, 3, 2]]))
    )
    with pytest.raises(CapacityError, match="salient point"):
        Adf(pairs=0).regions(flat)


def test_fuzzy_clusters_find_planted_groups_in_the_order_of_their_size():
    rng = np.random.default_rng(5)
    places = np.array([[5.0, 5.0], [0.0, 0.1], [1.0, 2.0]])
    truth = rng.integers(0, 3, 300)
    centres, shares = fuzzy_c_means(places[truth] + 0.05 * rng.normal(size=(300, 2)), 3)
    assert np.allclose(centres, places[[1, 2, 0]], atol=0.05)
    assert np.array_equal(np.argmax(shares, axis=1), np.array([2, 0, 1])[truth])
    assert np.allclose(shares.sum(axis=1), 1.0)
