"""What a tolerance promises is kept, or the model refused; what was rounded more coarsely is called that."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.checks.coarse_digits import coarse_digits
from meshmark.authentication.marks.candidates import room
from meshmark.authentication.marks.precision import precision_of, precisions_of
from meshmark.authentication.marks.ring_shapes import ring_shapes
from meshmark.authentication.marks.rings import ordered_rings
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.together import together
from meshmark.geometry.weld import weld
from meshmark.marking import authenticate, embed
from meshmark.marking.promises import ROUNDINGS, broken_by
from meshmark.mesh import Mesh
from tests.counting import some
from tests.keys import ID, KEY
from tests.shapes import pebble


@pytest.fixture(scope="module")
def tolerant():
    points, faces = pebble(56)
    return embed(
        Mesh(points, faces), KEY, id=ID, layers="authentication", payload="none", tolerance="tolerant"
    )


@pytest.fixture(scope="module")
def plain():
    """A model of a size at which a grid of 17 bits is a little coarser than what its marks bear."""
    points, faces = pebble(56)
    return embed(Mesh(points, faces), KEY, id=ID, layers="authentication", payload="none", tolerance="strict")


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
    def conform(vertices):
        return np.round(vertices, 3)


def _on_grid(mesh: Mesh, bits: int) -> Mesh:
    low, step = mesh.vertices.min(axis=0), np.ptp(mesh.vertices, axis=0).max() / (2**bits - 1)
    return Mesh(low + np.rint((mesh.vertices - low) / step) * step, mesh.faces)


def test_tolerant_marks_bear_every_rounding_that_they_promise_to(tolerant):
    for name in some(precisions_of(tolerant.mesh, "tolerant")[0].bears, least=7):
        _bears(tolerant, name)


def _bears(tolerant, name):
    rounded = ROUNDINGS[name][0](tolerant.mesh.vertices)
    assert (rounded != tolerant.mesh.vertices).any()
    found = authenticate(Mesh(rounded, tolerant.mesh.faces), KEY)
    assert (found.verdict, found.id) == ("authentic", ID)


def test_what_breaks_a_mark_is_told_by_name(plain):
    assert broken_by(plain.mesh, KEY, ID, ("turned", "floats", "decimals"), precision_of(plain.mesh)) is None
    broken = broken_by(plain.mesh, KEY, ID, ("floats", "side"), 1e-12)
    assert broken is not None
    assert broken.called == "a grid of 16 bits on the longest side"
    assert broken.unread.any()


@pytest.fixture(scope="module")
def coarse():
    """A model that the layer of authentication is left out of."""
    points, faces = pebble()
    mesh = Mesh(np.round(points, 3), faces, _Coarse())
    assert embed(mesh, KEY, id=ID, strength="strong").layers == "ownership"
    return mesh


@pytest.mark.parametrize("tolerance", ["strict", "web"])
def test_a_tolerance_that_is_asked_for_is_kept_or_refused(coarse, tolerance):
    with pytest.raises(CapacityError, match="authentication"):
        embed(coarse, KEY, id=ID, strength="strong", tolerance=tolerance)


def test_a_tolerance_without_marks_is_no_request(model):
    with pytest.raises(InputError, match="a tolerance is one of authentication marks"):
        embed(model, KEY, id=ID, layers="ownership", tolerance="strict")


def test_points_that_rounding_makes_one_are_one_before_they_are_marked():
    points, faces = pebble(40)
    a, b = faces[len(faces) // 2][:2]
    points = points.copy()
    points[b] = points[a] + 2e-7
    result = embed(
        Mesh(points, faces), KEY, id=ID, layers="authentication", payload="none", tolerance="strict"
    )
    assert (result.mesh.vertices[a] == result.mesh.vertices[b]).all()
    for name in ("decimals", "floats", "turned"):
        rounded = Mesh(ROUNDINGS[name][0](result.mesh.vertices), faces)
        assert authenticate(rounded, KEY).verdict == "authentic"


def test_only_points_within_reach_come_together():
    points = np.array([[0.0, 0, 0], [0.1, 0, 0], [1.0, 0, 0], [1.0, 0.05, 0], [1.0, 0.1, 0], [3.0, 0, 0]])
    placed = together(points, 0.11)
    assert (placed[0] == placed[1]).all()
    assert (placed[2] == placed[3]).all()
    assert (placed[2] == placed[4]).all()
    assert (placed[5] == points[5]).all()
    assert (together(points, 0.01) == points).all()
    chain = np.stack([np.arange(60) * 0.1, np.zeros(60), np.zeros(60)], axis=1)
    assert (together(chain, 0.11) == chain).all()


def _fan(*ring: tuple[float, float, float]) -> Mesh:
    count = len(ring)
    faces = [[0, 1 + each, 1 + (each + 1) % count] for each in range(count)]
    return Mesh(np.array([[0.0, 0.0, 0.0], *ring]), np.array(faces))


def _room(mesh: Mesh, unit: float) -> float:
    surface = weld(mesh)
    rings = [
        group.take(group.vertex == surface.point_of_vertex[0])
        for group in ordered_rings(surface.faces, len(surface.points))
    ]
    group = next(group for group in rings if len(group.vertex))
    return float(room(ring_shapes(surface.points, group), unit)[0])


def test_a_needle_ring_carries_no_mark_whatever_rounding_makes_of_its_normal():
    rng = np.random.default_rng(1)
    line = ((-1.4, 0.0, 0.0), (0.39, 0.0, 0.0), (0.98, 0.0, 0.0))
    triangle = ((-1.4, 0.1, 0.0), (0.39, -1.0, 0.0), (0.98, 1.0, 0.1))
    unit = 5e-4
    assert _room(_fan(*triangle), unit) > 10.0
    for _ in range(20):
        off = 1e-5 * rng.normal(size=(3, 3))
        assert _room(_fan(*(np.array(line) + off)), unit) < 10.0


def test_the_level_of_a_ring_that_carries_a_mark_does_not_hang_on_a_tie():
    """Of two farthest neighbours rounding makes either the first; the ring's spread depends on which."""
    rng = np.random.default_rng(5)
    unit = 2e-4
    tied_rings = []
    for _ in range(300):
        ring = rng.normal(size=(4, 3)) * [1.0, 1.0, 0.15]
        ring = ring[np.argsort(np.arctan2(ring[:, 1], ring[:, 0]))]
        ring -= ring.mean(axis=0)
        far = np.linalg.norm(ring, axis=1)
        first, second = np.argsort(far)[-2:]
        ring[first] *= far[second] / far[first]
        rooms = []
        for more in (-1e-6, 1e-6):
            tied = ring.copy()
            tied[first] *= 1.0 + more
            rooms.append(_room(_fan(*tied), unit))
        tied_rings.append(rooms)
    for one, other in some((rooms for rooms in tied_rings if min(rooms) > 10.0), least=20):
        assert one == pytest.approx(other, rel=0.42)  # within a level: a factor sqrt 2


@pytest.mark.parametrize(
    ("rounded", "called"),
    [
        (lambda v: np.round(v, 3), "3 decimals"),
        (lambda v: np.char.mod("%.4g", v).astype(float), "4 significant digits"),
        (lambda v: _on_grid(Mesh(v, np.empty((0, 3), np.int64)), 14).vertices, "a grid of 14 bits"),
        (
            lambda v: _on_grid(Mesh(v, np.empty((0, 3), np.int64)), 14).vertices.astype(np.float32),
            "a grid of 14 bits",
        ),
    ],
)
def test_coordinates_show_what_they_were_rounded_to(rounded, called):
    vertices = 1.7 * pebble(30)[0] + 0.2
    assert coarse_digits(vertices) is None
    found = coarse_digits(np.asarray(rounded(vertices), np.float64))
    assert found is not None
    assert found.called == called
    assert not found.off.any()


def test_a_model_rounded_everywhere_is_told_so_in_one_sentence(plain):
    found = authenticate(_on_grid(plain.mesh, 18), KEY)
    assert found.verdict == "altered"
    assert found.advice.startswith("Rounded to a grid of 18 bits everywhere")
    assert "regions altered" not in found.advice


@pytest.mark.parametrize("before", [True, False])
def test_an_edit_of_a_rounded_model_is_told(plain, before):
    top = plain.mesh.vertices[:, 1] > np.quantile(plain.mesh.vertices[:, 1], 0.93)
    moved = plain.mesh if before else _on_grid(plain.mesh, 18)
    vertices = moved.vertices.copy()
    vertices[top] += 0.003 * np.random.default_rng(2).normal(size=(int(top.sum()), 3))
    edited = Mesh(vertices, plain.mesh.faces)
    found = authenticate(_on_grid(edited, 18) if before else edited, KEY)
    assert found.verdict == "altered"
    assert "Changed beyond that: " in found.advice
    assert (found.altered & top).sum() > 0.6 * top.sum()
