"""Both layers together, and each alone, on shapes made by code."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.checks.checks import check
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.weld import weld
from meshmark.marking import authenticate, embed, extract
from meshmark.mesh import Mesh
from meshmark.strengths import BUDGETS
from tests.counting import some
from tests.keys import ID, KEY, OTHER
from tests.marked import marked_pebble
from tests.shapes import pebble

pytestmark = pytest.mark.usefixtures("short_search")


@pytest.fixture(scope="module")
def both():
    return marked_pebble()


def test_both_layers_are_there_by_default_and_both_are_read(model, both):
    assert (both.layers, both.id) == ("both", ID)
    assert both.carriers > 0
    assert both.mark_vertices > 0.15 * len(model.vertices)
    assert extract(both.mesh, KEY).id == ID
    found = authenticate(both.mesh, KEY)
    assert (found.verdict, found.id, found.altered_vertices) == ("authentic", ID, 0)
    assert found.content is not None
    assert (found.content.kind, len(found.content.content)) == ("miniature", both.payload_bytes)


@pytest.mark.parametrize("strength", ["subtle", "strong"])
def test_both_layers_together_keep_the_budget(model, strength):
    result = embed(model, KEY, id=ID, strength=strength, layers="both", payload="none")
    moved = np.sqrt(((result.mesh.vertices - model.vertices) ** 2).sum(axis=1).mean())
    share = moved / np.linalg.norm(np.ptp(model.vertices, axis=0))
    assert share <= BUDGETS[strength]
    assert result.rms_over_diagonal == pytest.approx(share)
    assert result.payload_bytes == 0
    assert extract(result.mesh, KEY).id == ID


def test_same_input_same_key_same_output(model, both):
    np.testing.assert_array_equal(embed(model, KEY, id=ID).mesh.vertices, both.mesh.vertices)


def test_marking_both_again_still_reads(both):
    assert extract(embed(both.mesh, KEY, id=ID).mesh, KEY).id == ID


def test_ownership_alone_is_not_authenticated_and_its_certificate_says_so():
    result = marked_pebble(layers="ownership")
    assert (result.layers, result.mark_vertices) == ("ownership", 0)
    blind = authenticate(result.mesh, KEY)
    assert (blind.verdict, blind.id, blind.altered_vertices) == ("inconclusive", ID, 0)
    assert "whether it was changed cannot be told" in blind.advice
    known = authenticate(result.mesh, KEY, reference=result.certificate)
    assert (known.verdict, known.altered_vertices) == ("authentic", 0)


def test_a_certificate_of_another_key_model_or_id_is_called_so(model, both):
    own = authenticate(both.mesh, KEY, reference=both.certificate)
    assert (own.mode, own.certificate, "certificate" in own.advice) == ("certificate", "own", False)
    other = embed(model, KEY, id=ID + 1, layers="authentication", payload="none")
    mine = embed(model, OTHER, id=ID, layers="authentication", payload="none")
    for result, words in ((other, "another mark"), (mine, "another key")):
        found = authenticate(both.mesh, KEY, reference=result.certificate)
        assert (found.verdict, found.certificate) == ("authentic", "foreign")
        assert words in found.advice
    assert "another mark" in extract(both.mesh, KEY, reference=other.certificate).advice


def test_authentication_alone_moves_little_and_carries_bytes(model):
    content = bytes(range(200))
    result = embed(model, KEY, id=ID, layers="authentication", payload=content)
    assert (result.layers, result.carriers, result.payload_bytes) == ("authentication", 0, 200)
    assert result.psnr_db > 75
    found = authenticate(result.mesh, KEY)
    assert (found.verdict, found.payload) == ("authentic", "recovered")
    assert found.content is not None
    assert (found.content.kind, found.content.content) == ("bytes", content)
    told = extract(result.mesh, KEY)
    assert (told.presence, told.id) == ("present", ID)
    assert [entry.layer for entry in told.evidence] == ["authentication"]


def test_a_file_is_carried_and_images_are_known(model, tmp_path):
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n and so on")
    result = embed(model, KEY, id=ID, layers="authentication", payload=tmp_path / "a.png")
    found = authenticate(result.mesh, KEY)
    assert found.content is not None
    assert (found.content.kind, found.content.content) == ("image", (tmp_path / "a.png").read_bytes())


def test_an_edit_is_found_and_nothing_else(both):
    vertices = both.mesh.vertices.copy()
    near = np.linalg.norm(vertices - vertices[700], axis=1)
    pushed = near < 0.15 * np.linalg.norm(np.ptp(vertices, axis=0))
    vertices[pushed] += [0.05, 0.0, 0.02]
    found = authenticate(both.mesh.with_vertices(vertices), KEY)
    assert found.verdict == "altered"
    assert (found.altered & pushed).sum() / (found.altered | pushed).sum() > 0.8
    called = {region.id for region in found.regions if region.verdict == "altered"}
    assert called
    assert set(found.region[pushed]) >= called
    assert f"{len(called)} of {len(found.regions)} regions altered" in found.advice
    assert all(region.probability > 0.5 for region in some(found.regions) if region.id in called)


def test_six_significant_digits_are_no_alteration(model):
    # Of a size at which they are coarser than six decimals and than single precision.
    larger = Mesh(1.2 * model.vertices, model.faces)
    marked = embed(larger, KEY, id=ID, layers="authentication").mesh
    size = 10.0 ** (np.floor(np.log10(np.maximum(np.abs(marked.vertices), 1e-12))) - 5.0)
    rounded = Mesh(np.round(marked.vertices / size) * size, marked.faces)
    assert np.abs(rounded.vertices - marked.vertices).max() > 4e-6
    assert authenticate(rounded, KEY).verdict == "authentic"


def test_noise_everywhere_is_an_alteration_everywhere(both):
    random = np.random.default_rng(3)
    noisy = both.mesh.with_vertices(both.mesh.vertices + 5e-4 * random.normal(size=both.mesh.vertices.shape))
    found = authenticate(noisy, KEY, reference=both.certificate)
    assert (found.verdict, found.id, found.altered.all()) == ("altered", ID, True)
    assert {region.verdict for region in found.regions} == {"altered"}
    blind = authenticate(noisy, KEY)
    assert (blind.verdict, blind.id) == ("inconclusive", ID)
    assert "changed everywhere" in blind.advice


def test_another_key_and_an_unmarked_model_are_not_marked(model, both):
    for mesh, key in ((both.mesh, OTHER), (model, KEY)):
        found = authenticate(mesh, key)
        assert (found.verdict, found.payload, found.id) == ("not_marked", "none", None)
        assert not found.altered.any()


def test_a_model_with_room_for_the_id_only_gets_that_and_a_remark():
    # Rounded coordinates: the file holds an id, but no fine marks.
    points, faces = pebble()
    mesh = _Coarse.mesh(np.round(points, 3), faces)
    result = embed(mesh, KEY, id=ID, strength="strong")
    assert (result.layers, result.mark_vertices) == ("ownership", 0)
    assert len(result.remarks) == 1
    assert result.remarks[0].startswith("the authentication layer is left out: ")
    with pytest.raises(CapacityError, match="authentication"):
        embed(mesh, KEY, id=ID, strength="strong", layers="both")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"layers": "three"}, "unknown layers"),
        ({"strength": "huge"}, "unknown strength"),
        ({"tolerance": "none"}, "unknown tolerance"),
        ({"payload": "no/such/file"}, "cannot read the payload"),
        ({"layers": "ownership", "payload": b"x"}, "a payload needs the authentication layer"),
    ],
)
def test_arguments_out_of_range_are_refused(model, arguments, message):
    with pytest.raises(InputError, match=message):
        embed(model, KEY, **{"layers": "authentication", **arguments})


class _Coarse:
    """A document that holds three decimals."""

    format = "obj"

    @staticmethod
    def deviations() -> tuple[()]:
        return ()

    @staticmethod
    def looks() -> None:
        return None

    @staticmethod
    def mesh(points, faces) -> Mesh:
        return Mesh(points, faces, _Coarse())

    @staticmethod
    def conform(vertices):
        return np.round(vertices, 3)


def test_a_payload_is_read_from_scattered_marks_though_the_map_believes_few(model):
    rng = np.random.default_rng(5)  # one draw in five or so takes all marks of a piece of the id
    small = rng.bytes(len(model.vertices) // 16)
    marked = embed(model, KEY, id=ID, layers="authentication", payload=small).mesh
    marks = np.flatnonzero(check(weld(marked), KEY).passed)
    moved = marked.vertices.copy()
    lost = rng.choice(marks, int(0.6 * len(marks)), replace=False)
    moved[lost] += 0.01 * rng.normal(size=(len(lost), 3))
    found = authenticate(marked.with_vertices(moved), KEY)
    assert found.verdict == "altered"
    assert found.content is not None
    assert found.content.content == small


def test_a_small_model_whose_marks_do_not_tell_the_id_is_marked_for_the_layer_below_tells_it():
    small = Mesh(*pebble(32))
    silent = False
    # One draw in two or so; where sums differ in their last digits, another one.
    for identity in (5, 6, 7, 8, 9):
        result = embed(small, KEY, id=identity, payload=b"few")
        silent = check(weld(result.mesh), KEY).nonce is None
        found = authenticate(result.mesh, KEY)
        assert (found.verdict, found.id) == ("authentic", identity)
        if silent:
            break
    assert silent
