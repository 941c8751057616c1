from __future__ import annotations

import networkx as nx
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.saliency.salient_points import salient_points


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), rings=st.integers(1, 3), levels=st.integers(1, 50))
def test_equals_the_definition_on_random_graphs(seed: int, rings: int, levels: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.permutation(40)[:, None] * np.ones(3)
    faces = rng.integers(0, 40, (45, 3))
    beta = rng.integers(0, levels, 40) / levels
    graph = adjacency(unique_edges(faces), 40)
    near = nx.from_scipy_sparse_array(graph)
    value = [(beta[v], points[v, 0]) for v in range(40)]
    expected = [
        v
        for v in range(40)
        if beta[v] > 0
        and all(value[v] >= value[u] for u in nx.single_source_shortest_path_length(near, v, rings))
    ]
    found = salient_points(beta, points, graph, rings=rings).tolist()
    assert found == sorted(expected, key=lambda v: value[v], reverse=True)


def test_the_order_of_the_points_does_not_matter_even_among_equals() -> None:
    grid = np.stack(np.meshgrid(np.arange(6.0), np.arange(6.0), [0.0]), axis=-1).reshape(-1, 3)
    faces = np.array([[6 * i + j, 6 * i + j + 1, 6 * i + j + 6] for i in range(5) for j in range(5)])
    order = np.random.default_rng(2).permutation(36)
    back = np.argsort(order)
    one = salient_points(np.ones(36), grid, adjacency(unique_edges(faces), 36), rings=2)
    other_graph = adjacency(unique_edges(back[faces]), 36)
    other = salient_points(np.ones(36), grid[order], other_graph, rings=2)
    np.testing.assert_array_equal(order[other], one)
