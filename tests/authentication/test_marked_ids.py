"""The ids that marks report, one after another, and where."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.authentication.checks.marked_ids import marked_ids
from meshmark.authentication.parameters import MARKED_LOG10
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from tests.keys import ID, KEY, OTHER, OTHER_ID
from tests.marked import marked_pebble, mosaic_of_pebbles, other_copy
from tests.shapes import pebble


def test_an_intact_model_has_one_id_everywhere():
    (found,) = marked_ids(surface_of(marked_pebble().mesh), KEY)
    assert found.id == ID
    assert found.log10_chance < -100.0
    assert found.points.mean() > 0.95


def test_unmarked_models_and_other_keys_have_none():
    assert marked_ids(surface_of(Mesh(*pebble(70))), KEY) == ()
    assert marked_ids(surface_of(marked_pebble().mesh), OTHER) == ()


@pytest.mark.parametrize("seed", [1, 2])
def test_half_a_model_has_its_id(seed):
    attack = parse_chain("crop:0.5+similarity:1+shuffle:1+float32:1")
    (found,) = marked_ids(surface_of(attack(marked_pebble().mesh, np.random.default_rng(seed))), KEY)
    assert found.id == ID
    assert found.points.mean() > 0.7


def test_both_copies_of_a_mosaic_are_named_where_they_lie():
    mosaic = mosaic_of_pebbles()
    found = {each.id: each.points for each in marked_ids(surface_of(mosaic), KEY)}
    assert found.keys() == {ID, OTHER_ID}
    height = mosaic.vertices[:, 0]
    middle = np.median(height)
    assert (height[found[ID]] <= middle).mean() > 0.95
    assert (height[found[OTHER_ID]] > middle).mean() > 0.95
    assert min(points.sum() for points in found.values()) > 0.6 * len(height) / 2.0


def test_copies_in_one_scene_are_named_each_with_the_scale_of_its_own():
    one, other = marked_pebble().mesh, other_copy().mesh
    vertices = np.concatenate([one.vertices, 0.4 * other.vertices[:, [1, 2, 0]] + [5.0, 0.0, 0.0]])
    scene = Mesh(vertices, np.concatenate([one.faces, other.faces + len(one.vertices)]))
    found = marked_ids(surface_of(scene), KEY)
    assert [each.id for each in found] == [ID, OTHER_ID]  # the larger one first
    assert [each.points[: len(one.vertices)].mean() > 0.9 for each in found] == [True, False]


def test_a_small_marked_part_is_read_by_itself_in_a_scene_of_unmarked_ones():
    part, around = other_copy(48).mesh, Mesh(*pebble(84))
    vertices = np.concatenate([around.vertices, 0.3 * part.vertices + [5.0, 0.0, 0.0]])
    scene = Mesh(vertices, np.concatenate([around.faces, part.faces + len(around.vertices)]))
    (found,) = marked_ids(surface_of(scene), KEY)
    assert found.id == OTHER_ID
    assert not found.points[: len(around.vertices)].any()


@pytest.mark.parametrize("seed", range(3))
def test_copies_mixed_vertex_by_vertex_name_nobody_else(seed):
    """Pieces of two ids, put together, are an id that no mark was made with."""
    one, other = marked_pebble().mesh, other_copy().mesh
    share = (0.1, 0.3, 0.5)[seed]
    taken = np.random.default_rng(seed).random((len(one.vertices), 1)) < share
    mixed = Mesh(np.where(taken, other.vertices, one.vertices), one.faces)
    found = marked_ids(surface_of(mixed), KEY)
    assert {each.id for each in found} <= {ID, OTHER_ID}
    assert max((each.log10_chance for each in found), default=MARKED_LOG10) <= MARKED_LOG10
