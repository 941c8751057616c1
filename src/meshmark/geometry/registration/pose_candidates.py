"""Candidate poses from descriptors: pairs of matches that agree about distance and normals, and what they imply.

Each landmark is matched to the surface places whose descriptors are most alike. Two matches are compatible if the
pair keeps its distance (up to the supposed scale) and the angles of its normals. A match that is compatible with
many matches which are compatible with each other is a good seed (second-order compatibility, arXiv:2203.14453);
a similarity is fitted to the best partners of each seed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.registration.landmarks import Landmarks
from meshmark.geometry.similarity import Similarity, fit_similarity
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Spots", "candidate_poses"]

MATCHES = 3
MOST_MATCHES = 1500
SLACK = 0.08
"""Distances may differ by this, in units of the frame's scale, and by RATIO of themselves."""
RATIO = 0.06
ANGLE = 0.3
NEAREST_PAIR = 0.25
SEEDS = 40
PARTNERS = 25


@dataclass(frozen=True, eq=False, kw_only=True)
class Spots:
    """Places on the suspect surface (n, 3), unit normals (n, 3), descriptors (n, DESCRIPTOR_LENGTH)."""

    places: FloatArray
    normals: FloatArray
    descriptors: FloatArray


def candidate_poses(landmarks: Landmarks, spots: Spots, scale: float) -> list[Similarity]:
    """Return poses (landmarks -> suspect) suggested by matches at about this scale, most supported first."""
    if len(spots.places) < 3:
        return []
    rows, columns = _matches(landmarks, spots)
    agree = _compatible(landmarks, spots, rows, columns, scale)
    support = agree * (agree @ agree)
    order = np.argsort(-support.sum(axis=1), kind="stable")[:SEEDS]
    poses = []
    for seed in order:
        partners = np.argsort(-support[seed], kind="stable")[:PARTNERS]
        partners = np.append(partners[support[seed, partners] > 0.0], seed)
        if len(partners) < 3:
            continue
        weights = np.append(support[seed, partners[:-1]], support[seed].max()).astype(float)
        poses.append(
            fit_similarity(landmarks.places[rows[partners]], spots.places[columns[partners]], weights)
        )
    return poses


def _matches(landmarks: Landmarks, spots: Spots) -> tuple[IntArray, IntArray]:
    """Return landmark and spot of each match, the most distinct ones where there are too many."""
    centre = landmarks.descriptors.mean(axis=0)
    unit = landmarks.descriptors.std(axis=0) + 1e-3
    ours, theirs = (landmarks.descriptors - centre) / unit, (spots.descriptors - centre) / unit
    count = min(MATCHES, len(theirs))
    distance, nearest = kd_tree(theirs).query(ours, count)
    rows, columns = np.repeat(np.arange(len(ours)), count), np.asarray(nearest).ravel()
    if len(rows) > MOST_MATCHES:
        best = np.sort(np.argsort(np.asarray(distance).ravel(), kind="stable")[:MOST_MATCHES])
        rows, columns = rows[best], columns[best]
    return rows, columns


def _compatible(
    landmarks: Landmarks, spots: Spots, rows: IntArray, columns: IntArray, scale: float
) -> NDArray[np.float32]:
    """Return (k, k): 1 where two matches agree about distance and angles, 0 elsewhere."""
    ours = _pair_features(landmarks.places[rows], landmarks.normals[rows])
    theirs = _pair_features(spots.places[columns] / scale, spots.normals[columns])
    far = ours[0]
    agree = (np.abs(far - theirs[0]) < SLACK + RATIO * far) & (far > NEAREST_PAIR)
    slope = ANGLE + SLACK / np.maximum(far, NEAREST_PAIR)
    agree &= np.abs(ours[1] - theirs[1]) < slope
    agree &= np.abs(ours[1].T - theirs[1].T) < slope
    agree &= np.abs(ours[2] - theirs[2]) < 1.5 * ANGLE
    return np.asarray(agree, np.float32)


def _pair_features(places: FloatArray, normals: FloatArray) -> tuple[NDArray[np.float32], ...]:
    """Return (k, k) each: distance, cosine of the row's normal with the way to the column, of both normals."""
    at, facing = places.astype(np.float32), normals.astype(np.float32)
    squared = np.einsum("ij,ij->i", at, at)
    distance = np.sqrt(np.maximum(squared[:, None] + squared - 2.0 * (at @ at.T), 0.0))
    along = facing @ at.T - np.einsum("ij,ij->i", facing, at)[:, None]
    return distance, np.asarray(along / np.maximum(distance, np.float32(1e-6))), facing @ facing.T
