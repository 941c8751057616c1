"""Schemes that compare with the original: how it is laid onto a suspect, and what they read there."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks.chain import parse_chain
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, InputError
from meshmark.mesh import Mesh
from meshmark.research import SCHEMES
from meshmark.research.schemes.rivals.alignment import differences
from meshmark.research.schemes.rivals.fcm import carriers
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.spectral import Spectral
from tests.shapes import pebble

KEY = Key(b"i" * 32)
BITS = np.random.default_rng(6).integers(0, 2, 64).astype(np.uint8)
CORNERS = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
BOX = Mesh(CORNERS, np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5]]))


@pytest.fixture(scope="module")
def host():
    """Fine enough that moves along the surface are seen where vertices have other numbers."""
    points, faces = pebble(72)
    return Mesh(points * [0.6, 0.9, 1.5], faces)


@pytest.fixture(scope="module", params=["spectral", "fcm"])
def scheme(request):
    return SCHEMES[request.param]


@pytest.fixture(scope="module")
def marked(scheme, host):
    return scheme.embed(host, BITS, KEY)


@pytest.mark.parametrize("attack", ["similarity:1", "noise:0.001", "shuffle:1"])
def test_the_bits_are_read_where_the_original_can_be_laid_on(scheme, marked, host, attack):
    suspect = parse_chain(attack)(marked, np.random.default_rng(7))
    found = scheme.extract(suspect, KEY, reference=host)
    assert found.present
    assert np.mean(found.bits != BITS) < 0.15


def test_an_original_is_needed(scheme, marked):
    with pytest.raises(InputError, match="not blind"):
        scheme.extract(marked, KEY)


def test_too_few_vertices_are_refused(scheme):
    with pytest.raises(CapacityError, match="the model has"):
        scheme.embed(BOX, BITS, KEY)


def test_differences_are_the_planted_ones(host):
    original = Host(host)
    rise = 1e-3 * np.sin(7.0 * host.vertices)
    turn = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    suspect = host.with_vertices(3.0 * (host.vertices + rise) @ turn - 4.0)
    moved, weights = differences(original, Host(suspect))
    assert (weights == 1.0).all()
    assert np.corrcoef(moved.ravel(), rise.ravel())[0, 1] > 0.95


def test_what_was_cut_off_has_no_weight(host):
    kept = host.faces[host.vertices[host.faces].mean(axis=1)[:, 2] < 0.8]
    original = Host(host)
    moved, weights = differences(original, Host(Mesh(host.vertices, kept)))
    inside = original.points[:, 2] < 0.75
    assert weights[inside].mean() > 0.99
    assert weights[original.points[:, 2] > 1.0].mean() < 0.05
    assert np.abs(moved[inside]).max() < 0.01 * original.diagonal


def test_another_model_is_not_laid_on(host):
    assert not SCHEMES["fcm"].extract(BOX, KEY, reference=host).present


def test_the_spectral_basis_is_orthonormal_and_smooth(host):
    original = Host(host)
    basis = Spectral()._basis(original)
    assert np.allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-6)
    rough = np.linalg.norm(basis[original.edges[:, 0]] - basis[original.edges[:, 1]], axis=0)
    assert rough[:10].max() < 0.5 * rough[-10:].min()


def test_carriers_have_six_neighbours_and_are_neither_the_flattest_nor_the_sharpest(host):
    original = Host(host)
    vertices, steps = carriers(original)
    assert (np.diff(original.graph.indptr)[vertices] == 6).all()
    assert 0 < len(vertices) < np.sum(np.diff(original.graph.indptr) == 6)
    assert (np.linalg.norm(steps, axis=1) > 0.0).all()
