"""A mark that is copied with its ring to another place of its model holds there, and is not believed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import meshmark as mm
from meshmark.authentication.checks.carried import Expected, Reading
from meshmark.authentication.checks.checks import check
from meshmark.authentication.checks.setting_search import likeliest_setting
from meshmark.authentication.checks.sweep import sweep
from meshmark.authentication.examination import examine
from meshmark.authentication.marks.candidates import HEADER, PAYLOAD, PLACE
from meshmark.authentication.marks.ring_shapes import ring_shapes
from meshmark.authentication.marks.rings import ordered_rings
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.marks.symbols import is_fine
from meshmark.authentication.payload.payload import pack
from meshmark.coding.erasure.erasure_code import ErasureCode
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh
from tests.counting import some
from tests.shapes import pebble

KEY = mm.Key(bytes(range(32)))
FAR = 0.7


@pytest.fixture(scope="module")
def marked():
    return mm.embed(Mesh(*pebble(72)), KEY, id=9, layers="authentication", payload="none").mesh


@pytest.fixture(scope="module")
def swept(marked):
    """Return what the marks say."""
    surface = weld(marked)
    groups = rings_of(surface)
    shapes = [ring_shapes(surface.points, group) for group in groups]
    setting = likeliest_setting(surface.points, groups, shapes, KEY, None)
    assert setting is not None
    swept = sweep(surface.points, list(zip(groups, shapes, strict=True)), setting, KEY, nonce=None)
    assert swept is not None
    return swept


@pytest.fixture(scope="module")
def kinds(marked, swept):
    """Return (p,): what kind of mark holds at each point, -1 where none does."""
    kinds = np.full(len(weld(marked).points), -1)
    kinds[swept.found.vertex[swept.read.holds]] = swept.found.kind[swept.read.holds]
    return kinds


def rigid(source: FloatArray, target: FloatArray) -> FloatArray:
    """Return `source` (k, 3) turned and moved, not scaled, to where it is nearest to `target`."""
    middle, goal = source.mean(axis=0), target.mean(axis=0)
    u, _, vt = np.linalg.svd((target - goal).T @ (source - middle))
    return goal + (source - middle) @ ((u * [1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt).T


def rings(mesh: Mesh) -> dict[int, IntArray]:
    groups = ordered_rings(mesh.faces, len(mesh.vertices))
    return {int(v): around for group in groups for v, around in zip(group.vertex, group.around, strict=True)}


def copied(marked: Mesh, kinds: np.ndarray, kind: int, count: int) -> Iterator[tuple[Mesh, int]]:
    """Yield models in which a mark of a kind was copied with its ring far away, and where."""
    about = rings(marked)
    random = np.random.default_rng(kind)
    for source in random.permutation(np.flatnonzero(kinds == kind))[:count].tolist():
        alike = [v for v in about if len(about[v]) == len(about[source])]
        away = [v for v in alike if np.linalg.norm(marked.vertices[v] - marked.vertices[source]) > FAR]
        target = int(random.choice(away))
        one, other = (np.append(about[v], v) for v in (source, target))
        points = marked.vertices.copy()
        points[other] = rigid(points[one], points[other])
        yield marked.with_vertices(points), target


def test_a_payload_symbol_that_was_copied_to_another_cell_is_wrong_there(marked, kinds):
    whole = examine(marked, KEY)
    source = ErasureCode(pack("none", whole=whole.payload.whole), whole.checks.symbol_bits)
    held = wrong = 0
    for suspect, target in some(copied(marked, kinds, PAYLOAD, 12)):
        found = check(weld(suspect), KEY)
        own = found.held.take(found.held.vertex == target)
        reading = Reading(key=KEY, nonce=9, symbol_bits=found.symbol_bits, frame=found.frame)
        expected = Expected(source=source, reading=reading, frame=found.frame, once=True)
        held += len(own.index) > 0
        wrong += len(own.index) > 0 and not expected.agrees(own).any()
        plain = replace(expected, reading=replace(reading, frame=None))
        assert not plain.agrees(found.held).mean() > 0.1, "without the frame no symbol is told"
    assert held >= 10
    assert wrong == held


def test_a_mark_that_says_another_place_does_not_hold_though_symbols_are_read_without_the_frame(
    marked, swept
):
    frame = check(weld(marked), KEY).frame
    assert frame is not None
    rows = np.flatnonzero(swept.read.holds & (swept.found.kind == PLACE))
    found, symbol = swept.found.take(rows), swept.read.symbol[rows]
    bits = check(weld(marked), KEY).symbol_bits
    coarse = ~is_fine(found.index)
    reading = Reading(key=KEY, nonce=9, symbol_bits=bits, frame=None)
    expected = Expected(
        source=lambda index: np.zeros(len(index), np.uint16), reading=reading, frame=frame, once=True
    )
    assert expected.in_place(found, symbol).all()
    other = symbol ^ (1 << (bits - 1))  # half the model away
    assert coarse.sum() > 20
    assert not expected.in_place(found, other)[coarse].any()
    assert replace(expected, frame=None).in_place(found, other).all()


def test_a_mark_that_tells_the_id_is_known_to_be_there_twice(marked, kinds):
    seen = [check(weld(suspect), KEY).repeated for suspect, _ in copied(marked, kinds, HEADER, 12)]
    assert sum(seen) >= 10  # of others a length of the ring may lie near a boundary
    assert not check(weld(marked), KEY).repeated


def test_a_mark_that_tells_its_place_is_not_believed_elsewhere(marked, kinds):
    for suspect, target in some(copied(marked, kinds, PLACE, 8)):
        assert not check(weld(suspect), KEY).passed[target]


def test_a_model_with_a_copied_mark_is_altered(marked, kinds):
    for kind in (HEADER, PLACE, PAYLOAD):
        ((suspect, _),) = copied(marked, kinds, kind, 1)
        assert mm.authenticate(suspect, KEY).verdict == "altered"


def test_the_mark_itself_is_as_it_was(marked):
    found = examine(marked, KEY)
    assert not found.altered.any()
    assert found.checks.frame is not None
    assert found.payload is not None
    assert found.payload.whole.once
    assert not found.checks.repeated


def test_a_small_model_has_marks_that_are_not_bound_to_places():
    small = mm.embed(Mesh(*pebble(34)), KEY, id=9, layers="authentication", payload="none")
    assert small.authentication is not None
    assert small.authentication.marks < 300
    assert mm.authenticate(small.mesh, KEY).verdict == "authentic"
