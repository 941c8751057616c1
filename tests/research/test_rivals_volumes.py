"""Volume moments: integrals over solids, directions that share them, and a mark that is read in every pose."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks.chain import parse_chain
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.mesh import Mesh
from meshmark.research.schemes.rivals.volume_moments import VolumeMoments
from meshmark.research.schemes.rivals.volumes import memberships, signed_volumes, solid_of, volumes
from tests.shapes import pebble

KEY = Key(b"v" * 32)
COUNT = 60
CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
BOX = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
     [1, 5, 7], [1, 7, 3]]
)  # fmt: skip


@pytest.fixture(scope="module")
def host():
    points, faces = pebble(60)
    return Mesh(points * [0.6, 0.9, 1.5], faces)


@pytest.fixture(scope="module")
def marked(host):
    return VolumeMoments().embed(host, np.tile(np.array([0, 1], np.uint8), 32), KEY)


def test_a_box_has_the_moments_of_a_box():
    sides, shift = np.array([3.0, 2.0, 1.0]), np.array([5.0, -7.0, 11.0])
    solid, axes = solid_of(sides * CORNERS + shift, BOX)
    assert np.isclose(abs(solid.volume), 6.0)
    assert np.allclose(solid.centre, shift + sides / 2)
    assert np.allclose(solid.covariance, np.diag(sides**2 / 12), atol=1e-9)
    assert np.allclose(axes.T @ solid.covariance @ axes, np.eye(3))


def test_a_surface_without_volume_has_no_solid():
    assert solid_of(CORNERS * [1.0, 1.0, 0.0], BOX) is None


def test_the_solid_turns_with_the_model(host):
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    solid, axes = solid_of(host.vertices, host.faces)
    other, turned = solid_of(3.0 * host.vertices @ turn + 1.0, host.faces)
    assert np.allclose(other.centre, 3.0 * solid.centre @ turn + 1.0)
    assert np.allclose(turned, turn.T @ axes / 3.0)


def test_directions_share_places_smoothly_and_all_of_them():
    rng = np.random.default_rng(2)
    places = rng.normal(size=(500, 3))
    shares = memberships(places, COUNT)
    assert np.allclose(shares.sum(axis=1), 1.0)
    assert np.allclose(shares.toarray(), memberships(7.0 * places, COUNT).toarray())
    near = memberships(places + 1e-6 * rng.normal(size=places.shape), COUNT)
    assert np.abs((near - shares).toarray()).max() < 1e-3


def test_the_directions_hold_the_volume_whatever_the_triangulation(host):
    points, faces = pebble(24)
    finer = parse_chain("midpoint:1")(Mesh(points, faces), np.random.default_rng(0))
    held, other = volumes(points, faces, COUNT), volumes(finer.vertices, finer.faces, COUNT)
    assert np.isclose(held.sum(), signed_volumes(points, faces).sum())
    assert np.allclose(held, other, atol=2e-3 * held.mean())


def test_the_mark_is_read_after_turning_subdividing_and_a_little_noise(marked):
    expected = np.tile([0, 1], 32)
    for chain in ("similarity:1", "midpoint:1", "noise:0.0005", "shuffle:1"):
        found = VolumeMoments().extract(parse_chain(chain)(marked, np.random.default_rng(3)), KEY)
        assert found.present, chain
        assert np.array_equal(found.bits, expected), chain


def test_an_open_model_is_refused_and_read_as_unmarked(host, marked):
    opened = Mesh(host.vertices, host.faces[1:])
    with pytest.raises(CapacityError, match="not closed"):
        VolumeMoments().embed(opened, np.zeros(64, np.uint8), KEY)
    assert not VolumeMoments().extract(Mesh(marked.vertices, marked.faces[1:]), KEY).present


def test_a_model_turned_inside_out_is_marked_all_the_same(host):
    bits = np.tile(np.array([1, 0], np.uint8), 32)
    mesh = VolumeMoments().embed(Mesh(host.vertices, host.faces[:, ::-1].copy()), bits, KEY)
    assert np.array_equal(VolumeMoments().extract(mesh, KEY).bits, bits)


def test_a_step_that_is_known_is_the_one_that_is_sought(host, marked):
    bits = np.tile(np.array([0, 1], np.uint8), 32)
    step = VolumeMoments().step_within(host, bits, KEY, 8e-4)
    knowing = VolumeMoments(step=step)
    assert np.array_equal(knowing.embed(host, bits, KEY).vertices, marked.vertices)
    with pytest.raises(CapacityError, match="the finest step"):
        VolumeMoments(step=30.0 * step).embed(host, bits, KEY)
