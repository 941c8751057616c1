from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from meshmark.errors import InputError
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.similarity import Similarity
from meshmark.recovery.miniature_placement import place_miniature
from meshmark.recovery.simplify import simplify
from tests.geometry.registering import lump


@pytest.fixture(scope="module")
def canonical():
    """A lump with knobs in its canonical coordinates."""
    points, faces = lump(48)
    return canonical_frame(points, faces).to_canonical(points), faces


def pose_of(seed: int) -> Similarity:
    rng = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed).as_matrix()
    return Similarity(scale=float(10.0 ** rng.uniform(-2, 2)), rotation=turn, shift=rng.normal(size=3))


def away(found: Similarity, true: Similarity, places: np.ndarray) -> float:
    """RMS distance of the places under two poses, in units of the scale."""
    return float(np.sqrt(np.square(found(places) - true(places)).sum(axis=1).mean()) / true.scale)


@pytest.mark.parametrize("seed", range(3))
def test_a_planted_pose_is_found_exactly(canonical, seed):
    places, faces = canonical
    true = pose_of(seed)
    found = place_miniature(canonical, true(places), faces, np.arange(len(places)))
    assert away(found, true, places) < 1e-6


@pytest.mark.parametrize("seed", range(2))
def test_altered_points_do_not_pull(canonical, seed):
    """A third of the surface is somewhere else; the intact points alone say where the miniature lies."""
    places, faces = canonical
    true = pose_of(seed)
    altered = places[:, 0] > np.quantile(places[:, 0], 0.67)
    scene = true(places + np.where(altered[:, None], [0.8, 0.5, 0.0], 0.0))
    found = place_miniature(canonical, scene, faces, np.flatnonzero(~altered))
    assert away(found, true, places) < 1e-3


def test_a_crude_miniature_lies_where_the_surface_does(canonical):
    places, faces = canonical
    true = pose_of(5)
    found = place_miniature(simplify(places, faces, 60), true(places), faces, np.arange(len(places)))
    assert away(found, true, places) < 0.02


def test_too_few_intact_points_are_refused(canonical):
    with pytest.raises(InputError, match="3 points are intact, expected enough"):
        place_miniature(canonical, *canonical, np.arange(3))


def test_a_miniature_of_another_model_is_refused():
    points, faces = lump(14)
    places = canonical_frame(points, faces).to_canonical(points)
    stretched = places * [1.0, 0.2, 3.0] + 0.4 * np.sin(7.0 * places[:, [1, 2, 0]])
    with pytest.raises(InputError, match="does not fit the intact part"):
        place_miniature((places, faces), stretched, faces, np.arange(len(places)))
