from __future__ import annotations

import base64
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from meshmark.certificate.binding import bound
from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certify import certify
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.areas import vertex_normals
from meshmark.marking import embed
from meshmark.marking.undo import FIELD, sealed, unmark, with_undo
from meshmark.mesh import Mesh
from tests.counting import Share
from tests.keys import KEY
from tests.low_poly import box, prism
from tests.shapes import pebble


def diagonal(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))


def off(one: Mesh, other: np.ndarray) -> float:
    return float(np.linalg.norm(one.vertices - other, axis=1).max()) / diagonal(one)


@pytest.fixture(scope="module")
def models() -> tuple[Mesh, Mesh, Certificate]:
    """A model, the same with a smooth bump and scattered small moves as the layers make them, its certificate."""
    points, faces = pebble(48)
    original = Mesh(points, faces)
    wave = 2e-3 * np.sin(4.0 * points[:, :1]) * vertex_normals(points, faces)
    rng = np.random.default_rng(1)
    jitter = 1e-4 * rng.normal(size=points.shape) * (rng.random((len(points), 1)) < 0.25)
    marked = Mesh((points + wave + jitter).astype(np.float32).astype(float), faces)
    return original, marked, sealed(certify(marked, 0.2, 0.05, "standard"), original, marked, KEY, 7)


def test_the_original_comes_back(models):
    original, marked, certificate = models
    found = unmark(marked, KEY, certificate)
    assert off(found.mesh, original.vertices) < 3e-7
    assert off(marked, original.vertices) > 1e-4
    assert found.exact
    rms = np.sqrt(((marked.vertices - original.vertices) ** 2).sum(axis=1).mean()) / diagonal(marked)
    assert found.rms_over_diagonal == pytest.approx(rms, rel=1e-3)


@dataclass(frozen=True)
class Rounding:
    """A file that keeps positions as single floats, or on a grid."""

    grid: float | None

    def deviations(self) -> tuple[()]:
        return ()

    def looks(self) -> None:
        return None

    def conform(self, vertices: np.ndarray) -> np.ndarray:
        if self.grid is None:
            return vertices.astype(np.float32).astype(float)
        return np.round(vertices / self.grid) * self.grid


def test_the_bound_that_is_told_holds_at_every_scale_and_precision():
    with Share(0.02) as share:
        is_unmarked_within_its_bound(share)


@settings(max_examples=20, deadline=None)
@given(
    scale=st.floats(-12, 12).map(lambda power: 10.0**power),
    away=st.floats(0.0, 40.0),
    digits=st.sampled_from([None, 4, 5, 6, 8]),
    seed=st.integers(0, 9),
)
@example(scale=1.0, away=0.0, digits=8, seed=6)
def is_unmarked_within_its_bound(share, scale, away, digits, seed):
    points, faces = pebble(16)
    rng = np.random.default_rng(seed)
    file = Rounding(None if digits is None else scale * 10.0**-digits)
    original = Mesh(file.conform(scale * (points + away)), faces)
    moves = 1e-3 * scale * rng.normal(size=points.shape)
    marked = Mesh(file.conform(original.vertices + moves), faces, document=file)
    certificate = sealed(certify(marked, 0.2, 0.05, "standard"), original, marked, KEY, 7)
    found = unmark(marked, KEY, certificate)
    assert found.exact
    assert off(original, found.mesh.vertices) <= found.within_over_diagonal
    share.case()
    if digits == 8:
        share.asserted()
        assert found.within_over_diagonal < 2.3e-7


def test_a_turned_scaled_and_moved_copy_in_single_precision_is_unmarked(models):
    original, marked, certificate = models
    turn = Rotation.from_euler("xyz", [1.0, 2.0, 3.0]).as_matrix()

    def placed(vertices: np.ndarray) -> np.ndarray:
        return 3.7 * vertices @ turn.T + [3.0, -1.0, 2.0]

    copy = Mesh(placed(marked.vertices).astype(np.float32).astype(float), marked.faces)
    found = unmark(copy, KEY, certificate)
    assert off(found.mesh, placed(original.vertices)) < 1e-6
    assert not found.exact


@pytest.mark.parametrize("shape", [box((6, 5, 4), (3.0, 2.0, 1.3)), prism(16, 6, 3.0)], ids=["box", "prism"])
def test_a_moved_copy_of_a_symmetric_model_is_unmarked(shape):
    """Its own frame may be any of several turns; in the wrong one the mark would be put in a second time."""
    original = Mesh(*shape)
    made = embed(original, KEY, id=7, layers="ownership")
    assert off(made.mesh, original.vertices) > 1e-4
    for angles in ([1.0, 2.0, 3.0], [0.5, -2.0, 1.0], [3.0, 0.3, -1.0]):
        turn = Rotation.from_euler("xyz", angles).as_matrix()
        copy = Mesh(2.5 * made.mesh.vertices @ turn.T + [1.0, 2.0, -3.0], original.faces)
        found = unmark(copy, KEY, made.certificate)
        assert off(found.mesh, 2.5 * original.vertices @ turn.T + [1.0, 2.0, -3.0]) < 1e-6


def test_the_certificate_keeps_it_through_a_file(models, tmp_path):
    original, marked, certificate = models
    certificate.save(tmp_path / "model.cert")
    loaded = Certificate.load(tmp_path / "model.cert")
    assert off(unmark(marked, KEY, loaded).mesh, original.vertices) < 3e-7


def test_it_takes_less_than_the_displacements_themselves(models):
    _, marked, certificate = models
    assert len(base64.b64decode(certificate.more[FIELD]["data"])) < 6 * len(marked.vertices)


def test_another_key_is_refused(models):
    _, marked, certificate = models
    with pytest.raises(InputError, match="another key"):
        unmark(marked, Key(bytes(32)), certificate)


@pytest.mark.parametrize("place", [0, 20, -1])
def test_damage_is_seen(models, place):
    _, marked, certificate = models
    content = bytearray(base64.b64decode(certificate.more[FIELD]["data"]))
    content[place] ^= 1
    value = {"version": 2, "data": base64.b64encode(content).decode()}
    changed = replace(certificate, more={**certificate.more, FIELD: value})
    with pytest.raises(InputError, match="was edited"):
        unmark(marked, KEY, changed)
    with pytest.raises(InputError, match="was changed"):
        unmark(marked, KEY, bound(changed, KEY, 7))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "no undo data"),
        ({"version": 1, "data": ""}, "has version 1, expected 2"),
        ({"version": 2}, "not in base64"),
        ({"version": 2, "data": "AAAA"}, "has 3 bytes"),
    ],
)
def test_other_fields_are_refused(models, value, text):
    _, marked, certificate = models
    rest = {name: kept for name, kept in certificate.more.items() if name != FIELD}
    with pytest.raises(InputError, match=text):
        unmark(marked, KEY, replace(certificate, more=rest if value is None else {**rest, FIELD: value}))


def test_a_certificate_that_is_not_bound_or_whose_frame_was_changed_is_refused(models):
    _, marked, certificate = models
    with pytest.raises(InputError, match="not bound to any key"):
        unmark(marked, KEY, replace(certificate, more={FIELD: certificate.more[FIELD]}))
    turned = replace(certificate.frame, axes=certificate.frame.axes[:, [1, 2, 0]])
    with pytest.raises(InputError, match="was edited"):
        unmark(marked, KEY, replace(certificate, frame=turned))


def test_other_faces_are_refused(models):
    original, marked, certificate = models
    other = Mesh(marked.vertices, marked.faces[::-1])
    with pytest.raises(InputError, match="vertex order"):
        unmark(other, KEY, certificate)
    with pytest.raises(InputError, match="differ in their faces"):
        with_undo(certificate, Mesh(original.vertices, original.faces[::-1]), marked, KEY)


def test_the_seal_tells_nothing_of_what_is_in_it(models):
    original, marked, certificate = models
    other = with_undo(certificate, marked, marked, KEY)
    content = np.frombuffer(base64.b64decode(certificate.more[FIELD]["data"]), np.uint8)
    assert np.bincount(content, minlength=256).max() < 4 * len(content) / 256  # as random bytes are
    assert certificate.more != other.more
    again = with_undo(certificate, original, marked, KEY)
    assert again.more == certificate.more
