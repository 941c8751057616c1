"""Cut and paste: from the same model with another mark, and from another model."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import ATTACKS, Given
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from tests.attacks.models import odd_strip, remarked, seam, seamed
from tests.shapes import pebble

MODEL = seamed()
SAME = remarked(MODEL, 3)
OTHER = Mesh(5.0 * pebble(36)[0] + 100.0, pebble(36)[1])


def pasted(share: float, donor: Mesh, seed: int = 1, mesh: Mesh = MODEL):
    return ATTACKS["paste"].apply(mesh, share, np.random.default_rng(seed), Given(donor=donor))


@pytest.mark.parametrize("share", [0.01, 0.2, 0.6])
def test_the_same_model_gives_the_positions_of_the_part(share):
    result = pasted(share, SAME)
    source = np.where(result.altered[:, None], SAME.vertices, MODEL.vertices)
    np.testing.assert_array_equal(result.mesh.vertices, source)
    np.testing.assert_array_equal(result.mesh.faces, MODEL.faces)
    places = np.unique(MODEL.vertices[result.altered], axis=0)
    assert abs(len(places) - share * len(np.unique(MODEL.vertices, axis=0))) <= 0.5
    first, second = seam(MODEL)
    np.testing.assert_array_equal(result.altered[first], result.altered[second])


def test_a_donor_equal_to_the_model_changes_nothing_and_marks_nothing():
    result = pasted(0.3, MODEL)
    np.testing.assert_array_equal(result.mesh.vertices, MODEL.vertices)
    assert not result.altered.any()


@pytest.mark.parametrize("share", [0.05, 0.3])
def test_another_model_gives_a_piece_that_is_laid_into_the_hole(share):
    result = pasted(share, OTHER)
    old = result.origin >= 0
    points = len(np.unique(MODEL.vertices, axis=0))
    np.testing.assert_array_equal(result.mesh.vertices[old], MODEL.vertices[result.origin[old]])
    gone = np.setdiff1d(np.arange(len(MODEL.vertices)), result.origin)
    assert abs(len(np.unique(MODEL.vertices[gone], axis=0)) - share * points) <= 0.5
    assert abs((~old).sum() - share * len(OTHER.vertices)) <= 0.5
    kept = ~np.isin(MODEL.faces, gone).any(axis=1)
    of_rest = old[result.mesh.faces].all(axis=1)
    np.testing.assert_array_equal(result.origin[result.mesh.faces[of_rest]], MODEL.faces[kept])
    assert not old[result.mesh.faces[~of_rest]].any(), "laid in without sewing"
    hole, piece = MODEL.vertices[gone], result.mesh.vertices[~old]
    size = np.linalg.norm(hole - hole.mean(axis=0), axis=1).max()
    assert np.linalg.norm(piece.mean(axis=0) - hole.mean(axis=0)) < 0.2 * size
    assert 0.7 < np.linalg.norm(piece - piece.mean(axis=0), axis=1).max() / size < 1.5


def test_a_piece_keeps_its_shape_and_faces_the_way_of_the_hole():
    result = pasted(0.1, OTHER)
    new = result.origin < 0
    inside = new[result.mesh.faces].all(axis=1)
    corners = result.mesh.vertices[result.mesh.faces[inside]]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
    assert outward @ (result.mesh.vertices[new].mean(axis=0) - MODEL.vertices.mean(axis=0)) > 0
    # Edges over the longest edge do not depend on where the piece lies and how large it is.
    edges = np.sort(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).ravel())
    own = np.linalg.norm(
        OTHER.vertices[OTHER.faces] - OTHER.vertices[np.roll(OTHER.faces, 1, axis=1)], axis=2
    )
    scale = np.linalg.norm(corners[0, 0] - corners[0, 1])
    ratios = own.ravel()[:, None] / own.ravel()[None]
    assert np.abs(ratios - edges[-1] / scale).min() < 1e-9


def test_the_rim_of_the_hole_counts_as_altered():
    result = pasted(0.1, OTHER)
    gone = np.setdiff1d(np.arange(len(MODEL.vertices)), result.origin)
    cut = MODEL.faces[np.isin(MODEL.faces, gone).any(axis=1)]
    boundary = {tuple(MODEL.vertices[v].tolist()) for v in np.setdiff1d(cut, gone)}
    old = result.origin >= 0
    marked = {tuple(row) for row in result.mesh.vertices[old & result.altered].tolist()}
    assert marked == boundary
    assert result.altered[~old].all()


@pytest.mark.parametrize("donor", [odd_strip(), OTHER], ids=["donor without enough faces", "model without"])
def test_parts_without_a_face_are_refused(donor):
    mesh = MODEL if donor is not OTHER else odd_strip()
    share = 0.01 if donor is not OTHER else 0.95
    with pytest.raises(InputError, match=r"leaves no face of the (donor's part|model), expected a"):
        pasted(share, donor, mesh=mesh)
