"""The id in the points of coarse models, end to end: embedded, attacked and read by the key alone."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.coding.keyed import rotation
from meshmark.errors import CapacityError
from meshmark.geometry.open_edges import open_edges
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import VisibleChange
from meshmark.geometry.weld import weld
from meshmark.marking import Embedding, embed, extract
from meshmark.mesh import Mesh
from meshmark.ownership.embedding_in_points import embed_in_points
from meshmark.ownership.embedding_task import EmbeddingTask
from meshmark.ownership.extraction import find
from meshmark.ownership.points.parameters import DISTINCT_BITS, LARGEST, SIDE, STEPS
from meshmark.ownership.search.search import Search
from meshmark.strengths import BUDGETS, VISIBLE_SHARES
from tests.counting import some
from tests.keys import ID, KEY, OTHER
from tests.low_poly import ball, box, frustum, loose_box, prism, soup, subdivided, table

BOX = ((6, 5, 4), (3.0, 2.0, 1.3))
SLAB = ((9, 8, 1), (3.0, 2.0, 0.4))
SHAPES = {
    "ball": ball(1),
    "box": box(*BOX),
    "frustum": frustum(),
    "table": table(),
    "prism": prism(16, 6, 3.0),
    "slab": box(*SLAB),
    "fine prism": prism(40, 5, 6.0),
}
# So coarse that its cells are not searched.
COLUMN = prism(30, 2, 8.0)
OTHER_DIAGONALS = {"box": box(*BOX, other=True)[1], "frustum": box(*BOX, other=True)[1]}
OTHER_DIAGONALS["slab"] = box(*SLAB, other=True)[1]


@cache
def marked(name: str) -> Embedding:
    return embed(Mesh(*{**SHAPES, "column": COLUMN}[name]), KEY, id=ID, layers="ownership")


def diagonal(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))


def on_grid(mesh: Mesh, bits: int) -> Mesh:
    low = mesh.vertices.min(axis=0)
    step = np.ptp(mesh.vertices, axis=0).max() / (2**bits - 1)
    return mesh.with_vertices(np.round((mesh.vertices - low) / step) * step + low)


def turned(mesh: Mesh) -> Mesh:
    """Return a mesh turned, scaled and shifted, in another order, in single precision."""
    random = np.random.default_rng(2)
    order, rows = random.permutation(len(mesh.vertices)), random.permutation(len(mesh.faces))
    vertices = 40.0 * mesh.vertices @ rotation(b"t" * 32).T - [3.0, 90.0, 1.0]
    faces = np.roll(np.argsort(order)[mesh.faces[rows]], 1, axis=1)
    return Mesh(vertices[order].astype(np.float32).astype(float), faces)


COPIES = {
    "as it is": lambda mesh: mesh,
    "turned": turned,
    "unwelded": lambda mesh: soup(mesh),
    "six decimals": lambda mesh: mesh.with_vertices(np.round(mesh.vertices, 6)),
    "fourteen bits": lambda mesh: on_grid(mesh, 14),
    "subdivided": lambda mesh: Mesh(*subdivided((mesh.vertices, mesh.faces))),
}


# What does not depend on the shape is done to one alone.
DONE_TO_ALL = ["turned", "fourteen bits"]
DONE_TO = {"box": COPIES, "table": [*DONE_TO_ALL, "unwelded"]}


@pytest.mark.parametrize("name", SHAPES)
def test_the_id_lies_in_points_and_survives_what_leaves_the_shape_alone(name):
    result = marked(name)
    assert result.ownership.at_points
    assert result.ownership.spacing == SIDE
    assert np.isclose(result.ownership.step * SIDE, STEPS).any()
    chosen = set(DONE_TO.get(name, DONE_TO_ALL))
    # A grid turns the axes of round models, whose moments are hardly apart, by more than is made good.
    for copy in some(chosen - ({"fourteen bits"} if "prism" in name else set())):
        found = extract(COPIES[copy](result.mesh), KEY, search="plain")
        assert (found.presence, found.id) == ("present", ID), copy
        assert found.log10_false_positive < -20.0
        assert found.carriers_agreeing > 0.55 * found.carriers


@pytest.mark.parametrize("name", OTHER_DIAGONALS)
def test_it_survives_other_diagonals(name):
    mesh = marked(name).mesh
    faces = OTHER_DIAGONALS[name]
    assert (np.sort(faces, axis=1) != np.sort(mesh.faces, axis=1)).any(axis=1).mean() > 0.5
    assert extract(Mesh(mesh.vertices, faces), KEY, search="plain").id == ID


@pytest.mark.parametrize("name", ["box", "column"])
def test_the_mirror_image_is_read_however_coarse(name):
    mesh = marked(name).mesh
    assert Search(surface=surface_of(mesh), key=KEY).has_cells == (name == "box")
    image = Mesh(mesh.vertices * [-1.0, 1.0, 1.0], mesh.faces[:, ::-1])
    found = extract(image, KEY, search="quick")
    assert found.id == ID
    assert "in the mirror image" in found.advice
    assert extract(image, KEY, search="plain").presence == "absent"


@pytest.mark.parametrize("name", ["ball", "table", "prism"])
def test_unmarked_models_and_wrong_keys_are_absent(name):
    for mesh, key in ((Mesh(*SHAPES[name]), KEY), (marked(name).mesh, OTHER)):
        found = extract(mesh, key, search="plain")
        assert (found.presence, found.id) == ("absent", None)
        assert found.log10_false_positive > -6.0


def test_a_wrong_key_is_absent_where_damage_is_undone_too():
    found = extract(marked("column").mesh, OTHER, search="quick")
    assert (found.presence, found.id) == ("absent", None)


@pytest.mark.parametrize(
    ("name", "strength"), [("ball", "subtle"), ("ball", "standard"), ("ball", "strong"), ("box", "strong")]
)
def test_every_strength_keeps_its_budget_and_is_seen_no_more_than_it_may(name, strength):
    mesh = Mesh(*SHAPES[name])
    result = embed(mesh, KEY, id=ID, layers="ownership", strength=strength)
    length = np.linalg.norm(result.mesh.vertices - mesh.vertices, axis=1) / diagonal(mesh)
    assert 0.0 < np.sqrt((length**2).mean()) <= BUDGETS[strength]
    assert length.max() <= LARGEST[strength] * (1.0 + 1e-6)
    assert result.rms_over_diagonal == pytest.approx(np.sqrt((length**2).mean()))
    surface = surface_of(mesh)
    seen = VisibleChange(surface.points, surface.faces).of(result.mesh.vertices)
    assert seen.share <= VISIBLE_SHARES[strength]
    assert extract(result.mesh, KEY, search="plain").id == ID


def test_same_input_same_key_same_id_same_output():
    mesh = Mesh(*SHAPES["ball"])
    before = mesh.vertices.copy()
    again = embed(mesh, KEY, id=ID, layers="ownership").mesh
    np.testing.assert_array_equal(again.vertices, marked("ball").mesh.vertices)
    np.testing.assert_array_equal(mesh.vertices, before)
    for key, identity in ((OTHER, ID), (KEY, ID + 1)):
        other = embed(mesh, key, id=identity, layers="ownership").mesh
        assert (other.vertices != again.vertices).any()


def test_a_watertight_model_stays_watertight_and_loose_corners_stay_together():
    whole = Mesh(*SHAPES["table"])
    mesh = soup(whole)
    result = embed(mesh, KEY, id=ID, layers="ownership")
    assert result.ownership.at_points
    surface = surface_of(result.mesh)
    assert len(surface.points) == len(whole.vertices) < len(mesh.vertices)
    assert not len(open_edges(surface.faces, len(surface.points))[0])
    np.testing.assert_array_equal(surface.point_of_vertex, surface_of(mesh).point_of_vertex)


def test_points_inside_the_edges_of_others_stay_in_them_and_the_id_is_read():
    mesh = Mesh(*loose_box())
    task = EmbeddingTask(mesh=mesh, key=KEY, identity=ID, strength="standard", rms=BUDGETS["standard"])
    result = embed_in_points(task)
    assert extract(result.mesh, KEY, search="plain").id == ID
    size = np.array([3.0, 2.0, 1.3])
    moved, seen = result.mesh.vertices, 0
    for low in (0.0, 1.3):
        at = np.flatnonzero(np.isclose(mesh.vertices[:, 1:], [0.0, low]).all(axis=1))
        order = at[np.argsort(mesh.vertices[at, 0])]
        share = mesh.vertices[order, :1] / size[0]
        line = moved[order[0]] + share * (moved[order[-1]] - moved[order[0]])
        np.testing.assert_allclose(moved[order], line, atol=1e-9)
        seen += len(order)
    assert seen > 16


def test_too_few_points_are_refused_with_their_number():
    with pytest.raises(
        CapacityError,
        match=rf"its 12 points carry (\d|[1-7]\d) bits of the code, {DISTINCT_BITS[64]} are needed; --bits 0 fits",
    ) as told:
        embed(Mesh(*ball(0)), KEY, id=ID, layers="ownership")
    assert "its triangles are" in str(told.value)


def test_unused_vertices_stay_where_they_are():
    points, faces = SHAPES["ball"]
    extra = np.array([[9.0, 9.0, 9.0], [-0.0, 0.0, 7.0]])
    result = embed(Mesh(np.concatenate([extra, points]), faces + 2), KEY, id=ID, layers="ownership")
    assert result.ownership.at_points
    assert result.mesh.vertices[:2].tobytes() == extra.tobytes()


@pytest.mark.parametrize("scale", [1e-80, 1e80])
def test_any_unit_will_do(scale):
    points, faces = SHAPES["ball"]
    result = embed(Mesh(scale * points, faces), KEY, id=ID, layers="ownership")
    assert result.ownership.at_points
    assert extract(result.mesh, KEY, search="plain").id == ID


def test_the_certificate_of_a_symmetric_model_tells_the_frame_that_the_mark_was_made_in():
    """That of the marked surface is another turn of it."""
    made = marked("column")
    held = made.ownership.frame.axes
    assert np.trace(surface_of(made.mesh).frame.axes.T @ held) == pytest.approx(-1.0, abs=0.01)
    np.testing.assert_array_equal(made.certificate.frame.axes, held)
    for seed in range(3):
        part = parse_chain("similarity:1+delete_part:0.3")(made.mesh, np.random.default_rng(seed))
        assert extract(part, KEY, reference=made.certificate, search="plain").id == ID


def test_the_certificate_of_both_layers_tells_that_frame_as_well():
    """Marks of authentication turn the frame of a nearly symmetric surface further."""
    made = embed(Mesh(*SHAPES["fine prism"]), KEY, id=ID, layers="both")
    for seed in range(4):
        part = parse_chain("similarity:1+delete_part:0.3")(made.mesh, np.random.default_rng(seed))
        search = Search(surface=weld(part), key=KEY, effort="plain", reference=made.certificate)
        assert find(search, lambda strategy: strategy.name == "points registered").ids == (ID,)


def test_the_certificate_and_the_original_read_the_mark_of_a_part():
    result = marked("slab")
    mesh, certificate = result.mesh, result.certificate
    assert certificate.at_points
    part = Mesh(mesh.vertices, mesh.faces[mesh.vertices[mesh.faces].mean(axis=1)[:, 0] < 2.8])
    assert extract(part, KEY, search="plain").id is None
    for reference in (certificate, Mesh(*SHAPES["slab"])):
        found = extract(part, KEY, search="plain", reference=reference)
        assert (found.presence, found.id) == ("present", ID)


def test_the_certificate_tells_an_id_to_look_for():
    made = marked("frustum")
    any_id = told = 0
    for seed in range(3):
        most_gone = parse_chain("similarity:1+delete_part:0.6")(made.mesh, np.random.default_rng(seed))
        search = Search(surface=weld(most_gone), key=KEY, effort="plain", reference=made.certificate)
        any_id += find(search).ids == (ID,)
        told += extract(most_gone, KEY, reference=made.certificate, search="plain").id == ID
    assert any_id == 0, "too little for any of 2^64 ids"
    assert told == 3


def test_a_copy_with_another_id_is_not_taken_for_the_certificates():
    mine, other = marked("box"), embed(Mesh(*SHAPES["box"]), KEY, id=ID + 1, layers="ownership")
    for part in some((0.1, 0.3, 0.6)):
        left = parse_chain(f"similarity:1+delete_part:{part}")(other.mesh, np.random.default_rng(0))
        found = extract(left, KEY, reference=mine.certificate)
        assert ID not in found.ids
    whole = extract(other.mesh, KEY, reference=mine.certificate)
    assert whole.id == ID + 1
    assert "that of another mark" in whole.advice


@pytest.mark.parametrize("kind", ["certificate", "original"])
def test_what_is_left_of_a_model_is_read_with_a_reference(kind):
    # With the original there are more ways to read, the fewer the smaller it is.
    name = "frustum" if kind == "certificate" else "ball"
    made = marked(name)
    reference = made.certificate if kind == "certificate" else Mesh(*SHAPES[name])
    mesh = turned(made.mesh)
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    away = np.linalg.norm(middles - middles[0], axis=1)
    left = Mesh(mesh.vertices, mesh.faces[away > np.quantile(away, 0.2)])
    assert extract(left, KEY, search="plain").id is None
    assert extract(left, KEY, reference=reference, search="plain").id == ID
    assert extract(left, OTHER, reference=reference, search="plain").id is None
