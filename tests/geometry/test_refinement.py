from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.registration.refinement import approach, refine
from meshmark.geometry.similarity import Similarity
from tests.geometry.registering import distance, lump, reference


def off(seed: int, size: float) -> Similarity:
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(size * rng.normal(size=3)).as_matrix()
    return Similarity(scale=1.0 + size * rng.normal(), rotation=turn, shift=size * rng.normal(size=3))


def test_the_planted_pose_comes_back_from_far_and_near():
    landmarks, frame = reference()
    surface = PreparedSurface(*lump(), frame)
    for seed in range(4):
        start = off(seed, 0.06)
        near = approach(landmarks, surface.coarse, start)
        assert distance(near, Similarity.identity(), landmarks.places) < 0.03
        fit = refine(landmarks, surface.coarse, surface.fine, near)
        assert distance(fit.pose, Similarity.identity(), landmarks.places) < 2e-3
        assert fit.doubt < 0.01


def test_what_was_cut_off_has_no_weight_and_does_no_harm():
    landmarks, frame = reference()
    points, faces = lump()
    canonical = frame.to_canonical(points)
    kept = faces[(canonical[faces, 0] < 0.2).all(axis=1)]
    surface = PreparedSurface(points, kept, frame)
    fit = refine(landmarks, surface.coarse, surface.fine, approach(landmarks, surface.coarse, off(1, 0.03)))
    assert distance(fit.pose, Similarity.identity(), landmarks.places) < 4e-3
    assert (fit.weights[landmarks.places[:, 0] > 0.4] == 0.0).all()
    assert np.median(fit.weights[landmarks.places[:, 0] < 0.0]) > 0.5


def test_a_plane_leaves_doubt():
    axis = np.linspace(-1.0, 1.0, 30)
    points = np.stack(np.meshgrid(axis, axis, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    corner = (np.arange(29)[:, None] * 30 + np.arange(29)).ravel()
    faces = np.concatenate(
        [
            np.column_stack([corner, corner + 30, corner + 1]),
            np.column_stack([corner + 30, corner + 31, corner + 1]),
        ]
    )
    surface = PreparedSurface(points, faces)
    landmarks = surface.landmarks(100)
    fit = refine(landmarks, surface.coarse, surface.fine, Similarity.identity())
    assert fit.doubt > 0.05


def test_far_from_the_surface_nothing_moves():
    landmarks, frame = reference()
    surface = PreparedSurface(*lump(), frame)
    away = Similarity(scale=1.0, rotation=np.eye(3), shift=np.array([50.0, 0.0, 0.0]))
    assert approach(landmarks, surface.coarse, away) is away
    fit = refine(landmarks, surface.coarse, surface.fine, away)
    assert fit.pose is away
    assert fit.doubt == np.inf
