"""The id in the parts of assemblies, end to end: each part taken out, or beside others, tells it blind."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from meshmark.coding.keyed import rotation
from meshmark.geometry.surface_of import surface_of
from meshmark.marking import Embedding, embed, extract
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.assembly_parts import assembly_parts, parts_held_apart
from meshmark.ownership.points.parameters import LARGEST
from meshmark.strengths import BUDGETS
from tests.keys import ID, KEY, OTHER
from tests.low_poly import Parts, ball, box, joined, prism

# A round part in each, whose axes an embedding has to settle, and in one a part too small for a mark of its own.
ROUND = prism(22, 14, 3.0)
SMALLER = (0.7 * ROUND[0] + [5.0, 1.0, 0.0], ROUND[1])
BOX, TINY = (
    box((8, 8, 6), (3.0, 2.0, 1.3), (4.0, 0.0, 0.3)),
    box((2, 2, 2), (0.5, 0.5, 0.5), (2.0, -3.0, 0.0)),
)
ASSEMBLIES: dict[str, tuple[Parts, ...]] = {"cells": (ball(3), SMALLER), "points": (ROUND, BOX, TINY)}
NAMES = list(ASSEMBLIES)


@cache
def marked(name: str) -> Embedding:
    return embed(Mesh(*joined(ASSEMBLIES[name])), KEY, id=ID, layers="ownership")


def taken_out(vertices: FloatArray, name: str, number: int) -> Mesh:
    """Return one part of an assembly by itself, with these positions of the whole."""
    sizes = [len(points) for points, _ in ASSEMBLIES[name]]
    start = sum(sizes[:number])
    return Mesh(vertices[start : start + sizes[number]], ASSEMBLIES[name][number][1])


def elsewhere(mesh: Mesh) -> Mesh:
    """Return a mesh turned, scaled and shifted, its faces in another order, in single precision."""
    moved = mesh.vertices @ rotation(b"elsewhere" * 4).T * 12.0 + [3.0, -1.0, 2.0]
    order = np.random.default_rng(3).permutation(len(mesh.faces))
    return Mesh(moved.astype(np.float32).astype(np.float64), mesh.faces[order])


@pytest.mark.parametrize("name", NAMES)
def test_the_whole_and_each_large_part_tell_the_id(name):
    made = marked(name)
    assert made.ownership.at_points == (name == "points")
    assert made.ownership.parts == (0, 1)
    assert made.remarks == (
        "2 parts carry the id by themselves as well, and tell it when they are taken out",
    )
    assert extract(elsewhere(made.mesh), KEY, search="plain").id == ID
    for number in range(2):
        part = elsewhere(taken_out(made.mesh.vertices, name, number))
        assert extract(part, KEY, search="plain").id == ID


def test_a_part_says_nothing_under_another_key_or_before_it_was_marked():
    part = elsewhere(taken_out(marked("points").mesh.vertices, "points", 1))
    assert extract(part, OTHER, search="plain").presence == "absent"
    unmarked = elsewhere(taken_out(joined(ASSEMBLIES["points"])[0], "points", 1))
    assert extract(unmarked, KEY, search="plain").presence == "absent"


def test_a_part_is_found_in_the_scene_of_somebody_else():
    part = taken_out(marked("cells").mesh.vertices, "cells", 1)
    scene = Mesh(*joined([(part.vertices, part.faces), (3.0 * ball(3)[0] - 9.0, ball(3)[1])]))
    found = extract(elsewhere(scene), KEY, search="plain")
    assert found.id == ID
    assert [entry.layer for entry in found.evidence] == ["points"]
    assert found.evidence[0].share < 0.3


@pytest.mark.parametrize("name", NAMES)
def test_the_parts_stay_within_what_the_whole_may_be_moved(name):
    made, before = marked(name), joined(ASSEMBLIES[name])[0]
    moved = np.linalg.norm(made.mesh.vertices - before, axis=1) / np.linalg.norm(np.ptp(before, axis=0))
    assert np.sqrt(np.mean(moved**2)) <= BUDGETS["standard"]
    assert moved.max() <= 1.3 * LARGEST["standard"]


def test_components_too_small_and_surfaces_in_one_piece_have_no_parts():
    assert [len(part.rows) for part in assembly_parts(surface_of(Mesh(*joined(ASSEMBLIES["points"]))))] == [
        332,
        322,
    ]
    assert assembly_parts(surface_of(Mesh(*ball(3)))) == ()
    assert assembly_parts(surface_of(Mesh(*joined([TINY, (TINY[0] + 5.0, TINY[1])])))) == ()


def test_points_that_touch_another_part_stay_where_they_are():
    corner = BOX[0] - BOX[0].min(axis=0) + ROUND[0][0]
    assert assembly_parts(surface_of(Mesh(*joined([ROUND, (corner, BOX[1])])))) == ()  # they share a point
    apart = assembly_parts(surface_of(Mesh(*joined([ROUND, (corner + np.array([1e-6, 0.0, 0.0]), BOX[1])]))))
    assert [len(part.rows) for part in apart] == [332, 322]
    assert [part.still.sum() for part in apart] == [1, 1]


def test_round_parts_alone_are_stretched_and_by_no_more_than_allowed():
    points, faces = joined([ROUND, (ball(3)[0] + 5.0, ball(3)[1])])
    surface = surface_of(Mesh(points, faces))
    parts = assembly_parts(surface)
    moved = parts_held_apart(surface.points, parts, 1e-3)
    ball_part, round_part = parts
    assert (moved[ball_part.rows] == surface.points[ball_part.rows]).all()
    assert 0.0 < np.linalg.norm(moved - surface.points, axis=1)[round_part.rows].max() < 3e-3
    before, after = (
        (-np.diff(round_part.surface(each).frame.moments)).min() for each in (surface.points, moved)
    )
    assert before < 1e-6 < 3e-4 < after
