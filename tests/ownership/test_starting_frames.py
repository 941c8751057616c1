from __future__ import annotations

import numpy as np
import pytest

from claims.models import load
from meshmark.attacks import find_attack, parse_chain
from meshmark.certificate.certify import certify
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.ownership.search.starting_frames import starting_frames
from tests.counting import some
from tests.geometry.registering import lump


def error(mesh: Mesh, reference: object, chain: str) -> float:
    """RMS distance of the best frame's canonical coordinates from the true ones, after a move of everything."""
    rng = np.random.default_rng(3)
    attacked = parse_chain(chain)(mesh, rng)
    moved = weld(find_attack("similarity")(attacked, 1.0, rng))
    frame = starting_frames(moved, reference)[0]
    welded = weld(mesh)
    truth = canonical_frame(welded.points, welded.faces).to_canonical(weld(attacked).points)
    return float(np.sqrt(np.square(frame.to_canonical(moved.points) - truth).sum(axis=1).mean()))


@pytest.mark.parametrize("kind", ["certificate", "original"])
def test_half_a_lump_gets_the_frame_of_the_whole(kind):
    mesh = Mesh(*lump())
    reference = certify(mesh, 0.25, 0.06, "standard") if kind == "certificate" else mesh
    assert error(mesh, reference, "crop:0.5") < 0.01


def test_frames_are_rotations_at_most_five_and_always_the_same():
    mesh = Mesh(*lump(48))
    surface = weld(parse_chain("crop:0.2+similarity")(mesh, np.random.default_rng(4)))
    one, other = starting_frames(surface, mesh), starting_frames(surface, mesh)
    assert 1 <= len(one) == len(other) <= 5
    for a, b in some(zip(one, other, strict=True)):
        np.testing.assert_allclose(a.axes.T @ a.axes, np.eye(3), atol=1e-12)
        assert np.linalg.det(a.axes) > 0.0
        np.testing.assert_array_equal(a.to_canonical(surface.points), b.to_canonical(surface.points))


@pytest.mark.shared
@pytest.mark.parametrize("chain", ["noise:0.02", "crop:0.5"])
@pytest.mark.parametrize("name", ["open_hand_closed", "classic_homer"])
def test_real_models(shared_data, name, chain):
    mesh = load(shared_data / f"models/train/{name}.off.xz")
    assert error(mesh, certify(mesh, 0.25, 0.06, "standard"), chain) < 0.01
