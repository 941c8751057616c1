"""Points give way to forces as a dense solution says, and leave what they carry, and planes, as they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sp

from meshmark.geometry.joints import joints_of
from meshmark.geometry.plane_patches import PlanePatches
from meshmark.geometry.stars import stars_of
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.points.coordinates import chosen_coordinates, ease_of, held
from meshmark.ownership.points.giving_way import GivingAlone, GivingTogether, PlanesKept
from tests.low_poly import box, frustum, joined, loose_box, prism

SHAPES = {
    "box": box((1, 1, 1), (3.0, 2.0, 1.3)),
    "finer": box((3, 2, 2), (3.0, 2.0, 1.3)),
    "frusta": joined([frustum(), (frustum()[0] * 0.7 + 2.0, frustum()[1])]),
    "prism": prism(7, 2, 3.0),
    "loose": loose_box(),
}


@dataclass(frozen=True, eq=False)
class Held:
    """A shape that carries: where, how it was set (p, 3), and how it gives way with and without its planes."""

    points: FloatArray
    carries: np.ndarray
    motion: FloatArray
    patches: PlanePatches
    joints: sp.csr_array
    alone: GivingAlone
    together: GivingTogether


@pytest.fixture(params=SHAPES)
def shape(request):
    surface = surface_of(Mesh(*SHAPES[request.param]))
    points = surface.points
    tensor = stars_of(points, surface.faces).tensor
    # On planes and creases what slides; at corners an axis by chance: a side all of which carry across it bends.
    carries, at_corners = chosen_coordinates(tensor, [(2, 1, 0), (0, 0, 1)], np.zeros(len(tensor), int))
    corners = np.flatnonzero(at_corners.any(axis=1))
    carries[corners, np.random.default_rng(8).integers(3, size=len(corners))] = True
    follow = held(ease_of(tensor), carries)[0]
    wanted = np.where(carries, np.random.default_rng(5).normal(size=points.shape), 0.0) * 1e-3
    rest = held(ease_of(0.01 * tensor), carries)[1]
    patches = PlanePatches.of(points, surface.faces)
    joints = joints_of(surface)
    return Held(
        points=points,
        carries=carries,
        motion=np.einsum("pij,pj->pi", follow, wanted),
        patches=patches,
        joints=joints,
        alone=GivingAlone(rest),
        together=GivingTogether(rest, PlanesKept.of(points, patches, joints)),
    )


def off_plane(shape, motion):
    return shape.patches.off_plane(shape.points + shape.joints @ motion)


def test_motions_of_planes_themselves_are_no_distance_from_them(shape):
    turn = np.cross([0.3, -0.2, 0.5], shape.points) + np.array([1.0, 2.0, 3.0])
    kept = PlanesKept.of(shape.points, shape.patches, None)
    away = kept.away @ turn.ravel()
    assert np.abs(away).max() > 1.0
    np.testing.assert_allclose(kept.slopes @ (kept.slopes.T @ away), away, atol=1e-9)
    np.testing.assert_allclose(
        (kept.slopes.T @ kept.slopes).toarray(), np.eye(kept.slopes.shape[1]), atol=1e-9
    )


def test_distances_from_planes_are_those_of_fitted_planes(shape):
    motion = 1e-4 * np.random.default_rng(1).normal(size=shape.points.shape)
    kept = PlanesKept.of(shape.points, shape.patches, shape.joints)
    off = kept.away @ motion.ravel()
    off -= kept.slopes @ (kept.slopes.T @ off)
    assert np.sqrt((off**2).mean()) == pytest.approx(off_plane(shape, motion), rel=1e-3)


def test_planes_are_plane_again_and_what_is_carried_stays(shape):
    flat = shape.together.flattened(shape.motion)
    before, after = off_plane(shape, shape.motion), off_plane(shape, flat)
    assert before > 1e-5
    assert after < 0.2 * before
    np.testing.assert_allclose(flat[shape.carries], shape.motion[shape.carries], atol=1e-12)
    assert np.linalg.norm(flat, axis=1).max() < 5.0 * np.linalg.norm(shape.motion, axis=1).max()


def test_a_patch_that_is_a_line_cannot_tilt_round_itself():
    points = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 6.1e-17, 0.0], [0.5, 6.1e-17, 0.0]])
    patches = PlanePatches.of(points, np.array([[0, 1, 3], [0, 3, 2]]))
    assert len(patches.point) == 4
    kept = PlanesKept.of(points, patches, None)
    gram = (kept.slopes.T @ kept.slopes).toarray()
    np.testing.assert_allclose(gram, np.diag(gram.diagonal()), atol=1e-9)
    np.testing.assert_allclose(np.sort(gram.diagonal()), [0.0, 1.0, 1.0], atol=1e-9)
    together = GivingTogether(np.tile(np.eye(3), (4, 1, 1)), kept)
    assert np.isfinite(together.flattened(np.eye(4, 3))).all()
    assert np.isfinite(together.given(np.ones((1, 3, 4)))).all()


def test_nothing_is_flattened_where_each_gives_way_alone(shape):
    assert shape.alone.flattened(shape.motion) is shape.motion


def test_forces_move_points_as_a_dense_solution_says(shape):
    forces = np.random.default_rng(2).normal(size=(2, 3, len(shape.points)))
    rest = sp.block_diag(list(shape.alone.rest)).toarray()
    flat = forces.transpose(0, 2, 1).reshape(2, -1)
    alone = (flat @ rest).reshape(2, -1, 3).transpose(0, 2, 1)
    np.testing.assert_allclose(shape.alone.given(forces), alone, rtol=1e-9, atol=1e-9)
    away, slopes = shape.together.planes.away.toarray(), shape.together.planes.slopes.toarray()
    bends = away - slopes @ (slopes.T @ away)
    # (inverse of rest + bends' bends)^-1, by what rest can reach
    wanted = rest - rest @ bends.T @ np.linalg.solve(
        np.eye(len(bends)) + bends @ rest @ bends.T, bends @ rest
    )
    together = (flat @ wanted).reshape(2, -1, 3).transpose(0, 2, 1)
    np.testing.assert_allclose(shape.together.given(forces), together, rtol=1e-6, atol=1e-6)
