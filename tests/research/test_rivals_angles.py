"""Angles on lattices, the order of a traversal, and units that verify themselves (3D-MDAQIM)."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.frame import canonical_frame
from meshmark.mesh import Mesh
from meshmark.research.schemes.rivals.angles import angles_of, turned
from meshmark.research.schemes.rivals.codeword import coded
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.mdaqim import STEPS, Mdaqim, _Plan
from meshmark.research.schemes.rivals.traversal import traversal
from tests.shapes import pebble

KEY = Key(b"m" * 32)


@pytest.fixture(scope="module")
def host():
    points, faces = pebble(60)
    return Mesh(points * [0.6, 0.9, 1.5], faces)


@pytest.fixture(scope="module")
def marked(host):
    return Mdaqim().embed(host, np.tile(np.array([0, 1], np.uint8), 32), KEY)


def test_angles_and_back(host):
    points = host.vertices
    angles = angles_of(points, canonical_frame(points, host.faces))
    assert np.allclose(turned(points, np.arange(len(points)), angles), points)


def test_quantised_angles_lie_on_the_lattice_of_their_bit_and_moved_least(host):
    angles = angles_of(host.vertices, canonical_frame(host.vertices, host.faces))
    rng, step = np.random.default_rng(1), float(STEPS[20])
    bits, dither = rng.integers(0, 2, angles.values.shape), rng.random(angles.values.shape)
    new = angles.quantised(bits, dither, step).values
    at = new / step - dither - bits / 2
    assert np.allclose(at, np.rint(at), atol=1e-6)
    moves = np.abs(new - angles.values)
    assert moves[:, 1].max() <= step / 2 + 1e-12
    assert ((new[:, 0] >= 0.0) & (new[:, 0] <= np.pi)).all()
    assert np.mean(moves[:, 0] <= step / 2 + 1e-12) > 0.99  # but for those that would leave the sphere


def test_steps_fit_into_a_turn_and_fall():
    turns = 2.0 * np.pi / STEPS
    assert np.allclose(turns, np.rint(turns))
    assert (np.diff(STEPS) < 0.0).all()


def test_a_traversal_visits_every_point_once_and_neighbours_first():
    _, faces = pebble(16)
    count = int(faces.max()) + 1
    both = np.concatenate([faces, faces + count])
    order = traversal(adjacency(unique_edges(both), 2 * count), count + 5)
    assert np.array_equal(np.sort(order), np.arange(2 * count))
    assert order[0] == count + 5
    assert (order[:count] >= count).all()  # the part of the start comes first
    graph = adjacency(unique_edges(both), 2 * count)
    degree = graph.indptr[order[0] + 1] - graph.indptr[order[0]]
    assert set(order[1 : degree + 1]) == set(
        graph.indices[graph.indptr[order[0]] : graph.indptr[order[0] + 1]]
    )


def test_units_verify_after_a_similarity_and_not_with_another_key(marked):
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = marked.with_vertices(0.2 * marked.vertices @ turn + 5.0)
    for mesh in (marked, moved):
        assert Mdaqim().verify(mesh, KEY)[1].mean() > 0.95
    wrong = Mdaqim().verify(marked, Key(b"w" * 32))[1]
    assert abs(wrong.mean() - 0.25) < 5 * np.sqrt(0.25 * 0.75 / len(wrong))


def test_what_was_altered_is_where_units_fail(marked):
    vertices = np.array(marked.vertices)
    vertices[100:140] += 0.004 * np.random.default_rng(3).normal(size=(40, 3))
    units, holds = Mdaqim().verify(marked.with_vertices(vertices), KEY)
    touched = np.isin(units, np.arange(100, 140)).any(axis=1)
    assert holds[touched].mean() < 0.6
    assert holds[~touched].mean() > 0.9


def test_angles_lie_on_the_lattice_of_the_marked_models_own_frame():
    """Marking makes the surface rough, which turns its frame: the mark has to be in the frame that is left."""
    points, faces = pebble(120)
    mesh = Mesh(points * [0.6, 0.9, 1.5], faces)
    marked = Host(Mdaqim().embed(mesh, np.zeros(64, np.uint8), KEY))
    plan = _Plan(Mdaqim(), marked, KEY)
    angles = angles_of(marked.points[plan.order], canonical_frame(marked.points, marked.faces))
    bits = coded(np.zeros(64, np.uint8), KEY, 32)[plan.bit]
    at = angles.values / plan.likeliest_step(angles) - plan.dither - bits / 2.0
    off = np.delete(at - np.rint(at), plan.last, axis=0)
    assert np.abs(np.median(off, axis=0)).max() < 0.02
