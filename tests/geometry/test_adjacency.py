from __future__ import annotations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.geometry.adjacency import adjacency, mean_squared_edge, ring_maximum, unique_edges
from meshmark.mesh import IntArray


def soup(seed: int, count: int) -> tuple[int, IntArray, nx.Graph[int]]:
    rng = np.random.default_rng(seed)
    size = int(rng.integers(3, 40))
    faces = rng.integers(0, size, (count, 3))
    graph = nx.Graph()
    graph.add_nodes_from(range(size))
    graph.add_edges_from((int(f[i]), int(f[i - 1])) for f in faces for i in range(3) if f[i] != f[i - 1])
    return size, faces, graph


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 1000), count=st.integers(0, 60))
def test_edges_and_matrix_equal_networkx(seed: int, count: int) -> None:
    size, faces, graph = soup(seed, count)
    edges = unique_edges(faces)
    assert edges.tolist() == sorted(sorted(edge) for edge in graph.edges)
    matrix = adjacency(edges, size)
    np.testing.assert_array_equal(matrix.toarray(), nx.to_numpy_array(graph))
    assert matrix.has_sorted_indices


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 1000), rings=st.integers(0, 4))
def test_ring_maximum_equals_breadth_first_search(seed: int, rings: int) -> None:
    size, faces, graph = soup(seed, 20)
    values = np.random.default_rng(seed).normal(size=size)
    within = [list(nx.single_source_shortest_path_length(graph, v, cutoff=rings)) for v in range(size)]
    expected = [values[near].max() for near in within]
    found = ring_maximum(values, adjacency(unique_edges(faces), size), rings)
    np.testing.assert_array_equal(found, expected)


def test_mean_squared_edge_of_a_right_triangle() -> None:
    points = np.array([[0, 0, 0], [3, 0, 0], [0, 4, 0]], float)
    assert mean_squared_edge(points, unique_edges(np.array([[0, 1, 2]]))) == pytest.approx(50 / 3)
    assert mean_squared_edge(points, np.zeros((0, 2), np.int64)) == 0.0
