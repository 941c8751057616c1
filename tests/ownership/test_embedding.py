"""The whole ownership layer on a shape made by code."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.coding.keyed import rotation
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import VisibleChange
from meshmark.marking import Embedding, extract
from meshmark.marking import embed as embed_layers
from meshmark.mesh import Mesh
from meshmark.ownership.embedding import embed as embed_ownership
from meshmark.ownership.extraction import find
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import TrialCounter
from meshmark.strengths import BUDGETS, VISIBLE_SHARES
from tests import low_poly
from tests.keys import ID, KEY, OTHER
from tests.low_poly import welded
from tests.marked import marked_pebble
from tests.shapes import pebble


def embed(mesh: Mesh, key: Key, **options: Any) -> Embedding:
    """Embed the ownership layer alone, unless other layers are asked for; None for those there is room for."""
    return embed_layers(mesh, key, **{"layers": "ownership", **options})


@pytest.fixture(scope="module")
def marked():
    return marked_pebble(layers="ownership")


def subdivide(mesh: Mesh) -> Mesh:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    corners = np.concatenate(
        [np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


@pytest.mark.parametrize("strength", list(BUDGETS))
def test_every_strength_keeps_its_budget_is_seen_no_more_than_it_may_and_is_read(model, strength):
    result = marked_pebble(layers="ownership", strength=strength)
    moved = np.sqrt(((result.mesh.vertices - model.vertices) ** 2).sum(axis=1).mean())
    diagonal = np.linalg.norm(np.ptp(model.vertices, axis=0))
    assert moved / diagonal <= BUDGETS[strength]
    seen = VisibleChange(model.vertices, model.faces).of(result.mesh.vertices)
    assert seen.share <= 1.2 * VISIBLE_SHARES[strength] + 0.005
    assert result.rms_over_diagonal == pytest.approx(moved / diagonal)
    assert extract(result.mesh, KEY).id == ID


def test_the_id_survives_what_leaves_the_shape_alone(marked):
    vertices, faces = marked.mesh.vertices, marked.mesh.faces
    random = np.random.default_rng(2)
    order = random.permutation(len(vertices))
    variants = {
        "similarity": Mesh(40.0 * vertices @ rotation(b"t" * 32).T - [3.0, 900.0, 1.0], faces),
        "shuffle": Mesh(vertices[order], np.argsort(order)[faces[random.permutation(len(faces))]]),
        "float32": Mesh(vertices.astype(np.float32).astype(float), faces),
        "midpoint": subdivide(marked.mesh),
    }
    for name, mesh in variants.items():
        found = extract(mesh, KEY)
        assert (found.presence, found.id) == ("present", ID), name
        assert found.log10_false_positive < -40
        assert found.carriers_agreeing > 0.85 * found.carriers


def test_frame_of_the_marked_surface_is_the_frame_of_the_original(model, marked):
    before, after = (canonical_frame(mesh.vertices, mesh.faces) for mesh in (model, marked.mesh))
    np.testing.assert_allclose(after.centre, before.centre, atol=2e-4 * before.scale)
    np.testing.assert_allclose(after.axes, before.axes, atol=2e-3)


def test_unmarked_models_and_wrong_keys_are_absent(marked):
    assert extract(Mesh(*pebble(24)), KEY).presence == "absent"
    wrong = extract(marked.mesh, OTHER, search="plain")
    assert (wrong.presence, wrong.id) == ("absent", None)
    assert wrong.log10_false_positive > -6


def test_same_input_same_key_same_output_and_input_unchanged(model, marked):
    before = model.vertices.copy()
    np.testing.assert_array_equal(embed(model, KEY, id=ID).mesh.vertices, marked.mesh.vertices)
    np.testing.assert_array_equal(model.vertices, before)
    assert (embed(model, OTHER, id=ID).mesh.vertices != marked.mesh.vertices).any()


def test_coincident_vertices_stay_coincident(model):
    corners = model.vertices[model.faces].reshape(-1, 3)
    soup = Mesh(corners, np.arange(len(corners)).reshape(-1, 3))
    result = embed(soup, KEY, id=ID, layers="both", payload="none")
    order = model.faces.ravel()
    first = np.full(len(model.vertices), -1)
    first[order[::-1]] = np.arange(len(order))[::-1]
    np.testing.assert_array_equal(result.mesh.vertices, result.mesh.vertices[first[order]])
    assert extract(result.mesh, KEY).id == ID


def test_vertices_outside_the_surface_do_not_move(model):
    extra = np.array([[9.0, 9.0, 9.0], [-0.0, 0.0, 7.0]])
    more = Mesh(np.concatenate([extra, model.vertices]), model.faces + 2)
    result = embed(more, KEY, id=ID, layers="both", payload="none")
    assert result.mesh.vertices[:2].tobytes() == extra.tobytes()


def test_a_symmetric_shape_gets_axes_of_its_own(model):
    unit = model.vertices / np.linalg.norm(model.vertices, axis=1)[:, None]
    ball = Mesh(unit, model.faces)
    result = embed(ball, KEY, id=ID, strength="strong")
    turned = Mesh((result.mesh.vertices @ rotation(b"u" * 32).T).astype(np.float32).astype(float), ball.faces)
    assert extract(turned, KEY).id == ID
    assert -np.diff(canonical_frame(turned.vertices, turned.faces).moments).max() > 5e-4


def test_too_little_surface_is_refused_with_what_is_missing():
    box = Mesh(*welded(low_poly.box((1, 1, 1), (1.0, 1.3, 1.7))))
    with pytest.raises(
        CapacityError,
        match=r"its triangles are [\d.]+ times as long .*; its 8 points carry \d+ bits .* 88 are",
    ):
        embed(box, KEY, id=ID)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"id": 2**64}, "64-bit"), ({"strength": "huge"}, "unknown strength")],
)
def test_arguments_out_of_range_are_refused(model, arguments, message):
    with pytest.raises(InputError, match=message):
        embed(model, KEY, **arguments)


def test_a_reserve_beyond_the_budget_is_refused(model):
    with pytest.raises(InputError, match="reserve"):
        embed_ownership(model, KEY, reserve=1.0)


def test_a_stray_vertex_does_not_stretch_the_budget(model):
    far = Mesh(np.concatenate([model.vertices, [[1e6, 0.0, 0.0]]]), model.faces)
    result = embed(far, KEY, id=ID)
    moved = np.sqrt(((result.mesh.vertices[:-1] - model.vertices) ** 2).sum(axis=1).mean())
    assert moved <= BUDGETS["standard"] * np.linalg.norm(np.ptp(model.vertices, axis=0))


@pytest.mark.parametrize("scale", [1e-80, 1e70])
def test_any_unit_will_do(scale):
    points, faces = pebble(40)
    result = embed(Mesh(points * scale, faces), KEY, id=ID)
    assert not result.ownership.at_points
    assert extract(result.mesh, KEY).id == ID


def test_models_have_lattices_of_their_own_under_one_key(model, marked):
    """What is learned of one model's lattice helps with no other: there the very same key reads nothing by it."""
    other = embed(model.with_vertices(model.vertices * [1.0, 1.0, 1.5]), KEY, id=ID)
    assert other.ownership.label != marked.ownership.label
    search = Search(surface=surface_of(marked.mesh), key=KEY, effort="plain")
    assert find(replace(search, label=marked.ownership.label)).id == ID
    assert not find(replace(search, label=other.ownership.label, trials=TrialCounter())).present


def test_the_certificate_tells_the_lattice_of_a_part(marked):
    """The invariants of a part are others; a reader with another label than the certificate's finds nothing."""
    certificate = marked.certificate
    assert certificate.lattice == str(marked.ownership.label)
    part = parse_chain("crop:0.2")(marked.mesh, np.random.default_rng(7))
    search = Search(surface=surface_of(part), key=KEY, effort="plain", reference=certificate)
    assert find(search).id == ID
    wrong = replace(certificate, lattice="0" * 32)
    assert find(replace(search, reference=wrong, trials=TrialCounter())).id is None


def test_marking_again_with_the_same_id_still_reads(marked):
    again = embed(marked.mesh, KEY, id=ID)
    assert extract(again.mesh, KEY).id == ID


def test_a_drawn_id_comes_back_and_the_result_speaks_json(model):
    result = embed(model, KEY)
    values = result.to_dict()
    assert int(values["id"], 16) == result.id == extract(result.mesh, KEY).id
    assert len(values["id"]) == 16
    assert "mesh" not in values
    assert "verified" not in values


def test_a_surface_too_small_to_judge_is_inconclusive():
    triangle = Mesh(np.eye(3), np.array([[0, 1, 2]]))
    found = extract(triangle, KEY)
    assert found.id is None
    assert found.presence in {"inconclusive", "absent"}
