"""What an embedding returns: a layer that is not there is None, and what is public can be used as it is."""

from __future__ import annotations

import json
from dataclasses import FrozenInstanceError, fields

import pytest

import meshmark as mm
from meshmark.marking import AuthenticationMark, OwnershipMark
from meshmark.marking.mark_request import MarkRequest
from meshmark.mesh import Mesh
from tests.counting import some
from tests.keys import ID, KEY
from tests.marked import marked_pebble
from tests.shapes import pebble

FIELDS = {
    "id", "bits", "layers", "vertices", "faces", "carriers", "mark_vertices", "payload_bytes", "rms_over_diagonal",
    "max_over_diagonal", "psnr_db", "tolerance", "remarks", "seconds", "strength", "spacing", "step",
}  # fmt: skip
PRESENT = {"both": (True, True), "ownership": (True, False), "authentication": (False, True)}


@pytest.fixture(scope="module", params=PRESENT)
def result(request):
    return marked_pebble(layers=request.param)


def test_a_layer_that_was_not_asked_for_is_none(result):
    assert isinstance(result, mm.Embedding)
    there = PRESENT[result.layers]
    assert (result.ownership is not None, result.authentication is not None) == there
    assert (result.carriers > 0, result.mark_vertices > 0) == there


def test_the_answer_has_the_fields_of_the_contract_and_nothing_made_up(result):
    values = json.loads(json.dumps(result.to_dict()))
    assert values.keys() == FIELDS
    lattice = (None, None) if result.ownership is None else (result.ownership.spacing, result.ownership.step)
    assert (values["spacing"], values["step"]) == lattice
    assert values["rms_over_diagonal"] == result.displacement.rms / result.displacement.diagonal


def test_results_are_frozen_and_keyword_only(result):
    with pytest.raises(FrozenInstanceError):
        result.id = 7
    for kind in (mm.Embedding, OwnershipMark, AuthenticationMark, MarkRequest):
        assert all(field.kw_only for field in some(fields(kind)))


def test_an_embedding_that_is_written_as_if_it_were_a_mesh_is_refused_by_name(result, tmp_path):
    with pytest.raises(mm.InputError, match=r"given an Embedding, expected a mesh: .* embedding\.mesh"):
        mm.write_mesh(result, tmp_path / "out.ply")
    with pytest.raises(mm.InputError, match="type str, expected a Mesh"):
        mm.write_mesh("mesh", tmp_path / "out.ply")
    assert list(tmp_path.iterdir()) == []


def test_the_options_of_embed_file_have_names(tmp_path):
    with pytest.raises(TypeError, match="positional"):
        mm.embed_file(Mesh(*pebble(16)), tmp_path / "out.ply", KEY, ID)
