"""Marks of authentication of models that have room for few: they tell with the id below what was changed."""

from __future__ import annotations

import numpy as np
import pytest

import meshmark as mm
from meshmark.authentication.examination import examine
from meshmark.authentication.marks.candidates import HEADER
from meshmark.authentication.marks.plan import plan
from meshmark.authentication.marks.signed_word import signed_points, signed_word
from meshmark.authentication.marks.symbols import header_symbols, outvoted
from meshmark.authentication.parameters import SMALL
from meshmark.errors import CapacityError
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from tests.counting import some
from tests.keys import ID, KEY, OTHER
from tests.low_poly import ball, joined
from tests.ownership.test_embedding_in_points import turned


@pytest.fixture(scope="module", params=[1, 2])
def small(request):
    """Models with room for 12 marks, and for 47, which do not carry all pieces of an id either."""
    return mm.embed(Mesh(*ball(request.param)), KEY, id=ID, layers="both")


def test_a_small_model_carries_both_layers_and_says_what_it_lacks(small):
    assert small.layers == "both"
    assert small.authentication.marks < 48
    assert small.authentication.payload_bytes == 0
    assert any("no part can be recovered" in remark for remark in small.remarks)
    found = mm.authenticate(small.mesh, KEY)
    assert (found.verdict, found.id, found.payload) == ("authentic", ID, "none")


def test_it_stays_authentic_turned_and_in_another_order(small):
    assert mm.authenticate(turned(small.mesh), KEY).verdict == "authentic"


def test_another_key_finds_nothing(small):
    assert mm.authenticate(small.mesh, OTHER).verdict == "not_marked"


def test_a_point_that_is_moved_is_called_altered(small):
    surface = surface_of(small.mesh)
    moves = 0.01 * surface.diagonal * np.random.default_rng(1).normal(size=(len(surface.points), 3))
    tried = some(range(0, len(surface.points), len(surface.points) // 7))
    altered, near = 0, 0
    for point in tried:
        points = surface.points.copy()
        points[point] += moves[point]
        found = mm.authenticate(small.mesh.with_vertices(points[surface.point_of_vertex]), KEY)
        altered += found.verdict == "altered"
        near += bool(found.altered[surface.point_of_vertex == point].all())
    assert altered == len(tried)
    assert near >= 0.8 * len(tried)


def test_a_component_that_is_gone_is_missed():
    two = joined([ball(1), (0.5 * ball(1)[0] + [4.0, 0.0, 0.0], ball(1)[1])])
    points, faces = joined(
        [two, ([[0.3, 0.2, 3.0], [0.9, 0.1, 3.2], [0.2, 0.8, 3.1]], np.array([[0, 1, 2]]))]
    )
    mesh = mm.embed(Mesh(points, faces), KEY, id=ID, layers="both").mesh
    assert examine(mesh, KEY).points_missing == 0
    found = mm.authenticate(Mesh(mesh.vertices[:-3], mesh.faces[:-1]), KEY)
    assert found.verdict == "altered"
    assert found.points_missing in (3, None)


def test_marks_that_hold_without_the_id_below_are_not_authentic(small, monkeypatch):
    nothing = mm.extract(small.mesh, OTHER, search="plain")
    assert nothing.id is None
    monkeypatch.setattr("meshmark.authentication.examination.extract", lambda *_, **__: nothing)
    found = mm.authenticate(small.mesh, KEY)
    assert (found.verdict, found.altered_vertices, found.id) == ("altered", 0, None)
    assert "the id beneath them is not read" in found.advice


def test_marks_of_small_models_that_lie_in_rings_alike_are_laid_out_as_those_that_do_not():
    points, faces = ball(2)
    surface = surface_of(Mesh(*joined([(points + np.array([3.0 * k, 0.0, 0.0]), faces) for k in range(4)])))
    planned = plan(surface, KEY, 1e-6, style=SMALL)
    assert (planned.found.kind == HEADER).all()
    assert len(planned.found.kind) >= 150


def test_what_is_asked_for_by_name_is_refused():
    with pytest.raises(CapacityError):
        mm.embed(Mesh(*ball(1)), KEY, id=ID, layers="both", payload=b"twelve bytes")
    with pytest.raises(CapacityError, match="needs 40"):
        mm.embed(Mesh(*ball(1)), KEY, id=ID, layers="authentication")


def test_the_number_of_points_is_told_by_the_marks():
    index = np.arange(0, 3200, 101, dtype=np.uint32)
    symbol = header_symbols(index, signed_word(KEY, ID, 217), SMALL.layouts[0].symbol)

    def ask(now, key=KEY, identity=ID):
        return signed_points(index, symbol, 4, key, identity, now=now)

    assert ask(217) == 217
    assert ask(205) == 217
    assert ask(217, OTHER) is None
    assert ask(217, identity=ID + 1) is None
    assert signed_points(index[:0], symbol[:0], 4, KEY, ID, now=217) is None


def test_of_pieces_that_differ_most_marks_decide():
    index = np.array([3, 3, 3, 4], np.uint32)
    lost = outvoted(index, np.array([7, 7, 2, 5]), 4, np.ones(4, bool))
    assert lost.tolist() == [False, False, True, False]
    assert not outvoted(index, np.array([7, 7, 2, 5]), 4, np.array([False, False, True, True]))[2:].any()
