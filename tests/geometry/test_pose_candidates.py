from __future__ import annotations

import numpy as np

from meshmark.geometry.registration.pose_candidates import Spots, candidate_poses
from tests.geometry.registering import any_similarity, distance, reference


def test_planted_matches_among_wrong_ones_give_the_pose():
    landmarks, _ = reference()
    true = any_similarity(2)
    rng = np.random.default_rng(0)
    described = landmarks.descriptors.copy()
    wrong = rng.permutation(len(landmarks))[: int(0.8 * len(landmarks))]
    described[wrong] = described[rng.permutation(wrong)]  # four in five lead astray
    spots = Spots(places=true(landmarks.places), normals=true.turn(landmarks.normals), descriptors=described)
    poses = candidate_poses(landmarks, spots, 1.1 * true.scale)
    assert distance(poses[0], true, landmarks.places) < 0.05


def test_no_spots_no_poses():
    landmarks, _ = reference()
    none = Spots(
        places=np.zeros((0, 3)),
        normals=np.zeros((0, 3)),
        descriptors=np.zeros((0, landmarks.descriptors.shape[1])),
    )
    assert candidate_poses(landmarks, none, 1.0) == []
