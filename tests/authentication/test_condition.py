"""Parts that were moved as one are told from what was changed, and shares of failed checks from alarms."""

from __future__ import annotations

import numpy as np
import pytest

import meshmark as mm
from meshmark.authentication.regions.condition import CONDITIONS
from tests.keys import KEY, OTHER
from tests.marked import marked_pebble

ACROSS = 84


def height(mesh: mm.Mesh) -> np.ndarray:
    z = mesh.vertices[:, 2]
    return (z - z.min()) / np.ptp(z)


def bent(share_of_diagonal: float) -> tuple[mm.Mesh, np.ndarray]:
    """Return the pebble with its top pushed aside as one, and which vertices are deep in the top."""
    mesh = marked_pebble(ACROSS).mesh
    blend = np.clip((height(mesh) - 0.7) / 0.15, 0.0, 1.0)
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    pushed = mesh.vertices + (blend**2 * (3.0 - 2.0 * blend))[:, None] * [
        share_of_diagonal * diagonal,
        0.0,
        0.0,
    ]
    return mesh.with_vertices(pushed), height(mesh) > 0.9


def shares(found: mm.Authentication, there: np.ndarray) -> dict[str, float]:
    """Return which share of these vertices has each condition."""
    counts = np.bincount(found.condition[there], minlength=len(CONDITIONS))
    return dict(zip(CONDITIONS, counts / there.sum(), strict=True))


def test_a_part_that_was_moved_as_one_is_said_to_be_intact_inside():
    suspect, top = bent(0.008)
    found = mm.authenticate(suspect, KEY)
    assert shares(found, top)["moved"] > 0.6
    low = height(marked_pebble(ACROSS).mesh) < 0.65
    assert shares(found, low)["intact"] == 1.0
    joint = np.nonzero(found.condition == CONDITIONS.index("altered"))[0]
    assert len(joint) > 100


def test_a_part_that_moved_less_than_can_be_told_is_cut_off():
    suspect, top = bent(0.002)
    found = mm.authenticate(suspect, KEY)
    assert found.verdict == "altered"
    assert shares(found, top)["cut_off"] > 0.9


def test_a_bump_is_neither_and_tints_its_region_by_its_share():
    mesh = marked_pebble(ACROSS).mesh
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    near = np.linalg.norm(mesh.vertices - mesh.vertices[100], axis=1) < 0.08 * diagonal
    noise = 0.002 * diagonal * np.random.default_rng(0).normal(size=mesh.vertices.shape)
    found = mm.authenticate(mesh.with_vertices(mesh.vertices + near[:, None] * noise), KEY)
    assert set(np.unique(found.condition)) == {CONDITIONS.index("intact"), CONDITIONS.index("altered")}
    assert found.failed_share[near].mean() > 0.7
    far = np.linalg.norm(mesh.vertices - mesh.vertices[100], axis=1) > 0.2 * diagonal
    assert found.failed_share[far].max() == 0.0
    failing = [region.failed / region.checks for region in found.regions if region.failed]
    assert 0 < len(failing) < len(found.regions)
    assert max(failing) < 0.7


def test_an_intact_model_has_no_failed_checks_and_another_key_checks_nothing():
    mesh = marked_pebble().mesh
    found = mm.authenticate(mesh, KEY)
    assert found.failed_share.max() == pytest.approx(0.0)
    assert set(np.unique(found.condition)) == {CONDITIONS.index("intact")}
    found = mm.authenticate(mesh, OTHER)
    assert np.isnan(found.failed_share).all()
    assert set(np.unique(found.condition)) == {CONDITIONS.index("unchecked")}
