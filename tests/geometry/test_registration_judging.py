from __future__ import annotations

import numpy as np

from meshmark.geometry.registration.agreement import judge
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.similarity import Similarity
from tests.geometry.registering import any_similarity, lump, reference


def test_the_true_pose_agrees_from_both_sides_and_others_do_not():
    landmarks, frame = reference()
    surface = PreparedSurface(*lump(), frame)
    share, explained = judge(landmarks, surface.coarse, surface.judges, Similarity.identity())
    assert min(share, explained) > 0.9
    for seed in range(5):
        turned = Similarity(scale=1.0, rotation=any_similarity(seed).rotation, shift=np.zeros(3))
        assert max(judge(landmarks, surface.coarse, surface.judges, turned)) < 0.6


def test_half_a_surface_is_explained_by_a_share_of_the_landmarks():
    landmarks, frame = reference()
    points, faces = lump()
    kept = faces[(frame.to_canonical(points)[faces, 1] > 0.0).all(axis=1)]
    surface = PreparedSurface(points, kept, frame)
    share, explained = judge(landmarks, surface.coarse, surface.judges, Similarity.identity())
    assert explained > 0.9
    # Near the cut a landmark may still lie in the plane of what is left.
    assert np.mean(landmarks.places[:, 1] > 0.0) <= share < np.mean(landmarks.places[:, 1] > -0.3)


def test_far_away_nothing_agrees():
    landmarks, frame = reference()
    surface = PreparedSurface(*lump(), frame)
    away = Similarity(scale=1.0, rotation=np.eye(3), shift=np.array([50.0, 0.0, 0.0]))
    assert judge(landmarks, surface.coarse, surface.judges, away) == (0.0, 0.0)
