"""Marks and their checks: round trips, benign operations, edits, forgeries."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from numpy.typing import NDArray

from meshmark.attacks import ATTACKS
from meshmark.attacks.attack import Given
from meshmark.authentication.checks.altered_points import altered_points
from meshmark.authentication.checks.checks import Checks, check
from meshmark.authentication.marks.candidates import level_of, room
from meshmark.authentication.marks.plan import Marked, mark, plan
from meshmark.authentication.marks.precision import precision_of, precisions_of
from meshmark.authentication.marks.ring_shapes import ring_shapes
from meshmark.authentication.marks.rings import ordered_rings
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.counting import some
from tests.shapes import hoop, pebble

KEY, OTHER = Key(bytes(range(32))), Key(bytes(range(1, 33)))
ID = 0x0123456789ABCDEF


def _symbols(index: NDArray[np.uint32]) -> NDArray[np.uint16]:
    return (index & np.uint32(15)).astype(np.uint16)


def _make(nonce: int = ID, across: int = 80) -> tuple[Mesh, Mesh, Marked]:
    points, faces = pebble(across)
    points = points * 10.0
    points.setflags(write=False)
    mesh = Mesh(points, faces)
    done = mark(plan(weld(mesh), KEY, precision_of(mesh)), KEY, nonce, _symbols)
    return mesh, Mesh(done.points, faces), done


ORIGINAL, MARKED, DONE = _make()


def _check(mesh: Mesh, key: Key = KEY, nonce: int | None = None) -> Checks:
    return check(weld(mesh), key, nonce)


def _failing(found: Checks) -> NDArray[np.bool_]:
    return found.eligible & ~found.verified


def test_all_marks_hold_and_every_eligible_point_has_a_voucher() -> None:
    found = _check(MARKED)
    assert found.nonce == ID
    assert found.passed[plan(weld(ORIGINAL), KEY, precision_of(ORIGINAL)).marks].all()
    assert found.eligible.mean() > 0.95
    assert not _failing(found).any()
    assert found.log10_chance < -100.0
    assert found.symbol_bits == DONE.symbol_bits
    assert found.step == pytest.approx(DONE.step, rel=0.05)


def test_payload_symbols_come_back_by_index() -> None:
    found = _check(MARKED)
    prepared = plan(weld(ORIGINAL), KEY, precision_of(ORIGINAL))
    assert prepared.payload_marks > 0.7 * DONE.count
    right = found.carried.value == _symbols(found.carried.index)
    assert right.mean() > 0.99
    assert set(prepared.payload_index.tolist()) <= set(found.carried.index[right].tolist())


def test_no_point_moves_farther_than_its_ring_allows_and_most_do_not_move() -> None:
    moved = (DONE.points != ORIGINAL.vertices).any(axis=1)
    assert moved.sum() <= DONE.count < 0.34 * len(moved)
    rms = np.sqrt(((DONE.points - ORIGINAL.vertices) ** 2).sum(axis=1).mean())
    assert 20.0 * np.log10(np.linalg.norm(np.ptp(ORIGINAL.vertices, axis=0)) / rms) >= 80.0


def test_the_same_input_gives_the_same_marks() -> None:
    np.testing.assert_array_equal(_make()[1].vertices, MARKED.vertices)


@pytest.mark.parametrize("nonce", [None, ID])
def test_another_key_or_an_unmarked_model_says_nothing(nonce: int | None) -> None:
    for mesh, key in ((MARKED, OTHER), (ORIGINAL, KEY)):
        found = _check(mesh, key, nonce)
        assert found.log10_chance > -6.0
        assert found.passed.mean() < 0.05


def test_another_id_leaves_no_mark_but_by_chance() -> None:
    found = _check(MARKED, nonce=ID ^ (0x5555 << 24))
    assert found.passed.mean() < 0.03


@pytest.mark.parametrize(
    "name",
    [
        "similarity",
        "shuffle",
        "float32",
        "unweld",
        "file_obj",
        "file_ply",
        "file_stl",
        "file_glb",
        "file_3mf",
    ],
)
def test_benign_operations_leave_every_voucher(name: str) -> None:
    found = _check(ATTACKS[name](MARKED, 1, np.random.default_rng(5)))
    assert found.nonce == ID
    assert not _failing(found).any()


def test_unused_vertices_do_not_matter() -> None:
    stray = Mesh(np.concatenate([MARKED.vertices, [[50.0, 0.0, 0.0]]]), MARKED.faces)
    found = _check(stray)
    assert found.nonce == ID
    assert not _failing(found).any()


@pytest.mark.parametrize("role", ["mark", "ring"])
def test_single_moved_points_are_seen_and_nothing_else(role: str) -> None:
    marks = plan(weld(ORIGINAL), KEY, precision_of(ORIGINAL)).marks
    rng = np.random.default_rng(2)
    points = _far_apart(rng.permutation(marks))
    if role == "ring":
        faces = [MARKED.faces[(MARKED.faces == point).any(axis=1)][0] for point in points]
        points = [int(face[~np.isin(face, marks)][0]) for face in faces]
    assert len(points) >= 12
    way = rng.normal(size=(len(points), 3))
    vertices = MARKED.vertices.copy()
    # The step of a ring is its spread (3.3 at the median) times the smallest step, and 1.42 times that at most.
    vertices[points] += 1.42 * 3.3 * DONE.step * way / np.linalg.norm(way, axis=1)[:, None]
    found = _failing(_check(Mesh(vertices, MARKED.faces), nonce=ID))
    near = [_around([point]) for point in points]
    assert np.mean([found[around].any() for around in near]) >= 0.85
    assert not np.delete(found, _around(np.concatenate(near))).any()


def _far_apart(points: NDArray[np.int64]) -> list[int]:
    chosen: list[int] = []
    for point in points.tolist():
        away = np.linalg.norm(MARKED.vertices[chosen] - MARKED.vertices[point], axis=1)
        if len(chosen) < 20 and (away > 4.0).all():
            chosen.append(point)
    return chosen


def _around(points: NDArray[np.int64] | list[int]) -> NDArray[np.int64]:
    return np.unique(MARKED.faces[np.isin(MARKED.faces, points).any(axis=1)])


@pytest.mark.parametrize("name", ["bump", "dent", "move_part", "delete_part", "replace_part"])
@pytest.mark.parametrize("share", [0.02, 0.1])
def test_the_map_finds_an_edit(name: str, share: float) -> None:
    attacked = ATTACKS[name].apply(MARKED, share, np.random.default_rng(4))
    surface = weld(attacked.mesh)
    found = altered_points(surface, check(surface, KEY, ID))[surface.point_of_vertex]
    truth = attacked.altered
    assert truth is not None
    assert (truth & found).sum() >= 0.9 * truth.sum()
    assert (truth & found).sum() >= 0.7 * (truth | found).sum()


def test_an_intact_model_has_an_empty_map() -> None:
    surface = weld(MARKED)
    assert not altered_points(surface, check(surface, KEY)).any()


def test_a_part_of_another_marked_model_is_found_though_the_key_is_the_same() -> None:
    donor = _make(nonce=ID ^ 0xFFFF)[1]
    attacked = ATTACKS["paste"].apply(MARKED, 0.1, np.random.default_rng(1), Given(donor=donor))
    inside = attacked.altered
    assert inside is not None
    found = _check(attacked.mesh)
    assert found.nonce == ID
    assert found.verified[inside].mean() < 0.03


def test_a_part_of_another_place_of_the_model_is_found() -> None:
    donor = ATTACKS["shuffle"](MARKED, 1, np.random.default_rng(3))
    attacked = ATTACKS["paste"].apply(MARKED, 0.1, np.random.default_rng(1), Given(donor=donor))
    assert attacked.altered is not None
    found = _check(attacked.mesh)
    assert (found.verified & attacked.altered).sum() <= 0.02 * attacked.altered.sum()
    assert _failing(found)[attacked.altered].any()


def test_a_model_moved_all_over_is_not_marked_any_more() -> None:
    rng = np.random.default_rng(6)
    noise = rng.normal(size=MARKED.vertices.shape) * 20.0 * DONE.step
    found = _check(Mesh(MARKED.vertices + noise, MARKED.faces), nonce=ID)
    assert found.log10_chance > -6.0


def test_what_cannot_be_marked_is_refused() -> None:
    surface = weld(ORIGINAL)
    with pytest.raises(InputError, match="precision"):
        plan(surface, KEY, 0.0)
    with pytest.raises(InputError, match="64 bits"):
        mark(plan(surface, KEY, 1e-6), KEY, 1 << 64, _symbols)
    with pytest.raises(InputError, match="payload symbol"):
        mark(plan(surface, KEY, 1e-6), KEY, 0, lambda index: np.full(len(index), 65535, np.uint16))
    with pytest.raises(CapacityError, match="precision"):
        plan(surface, KEY, 1.0)
    with pytest.raises(CapacityError, match="room"):
        plan(weld(Mesh(*pebble(16))), KEY, 1e-7)
    with pytest.raises(CapacityError, match="faces"):
        plan(weld(Mesh(ORIGINAL.vertices, np.empty((0, 3), np.int64))), KEY, 1e-6)


def test_words_have_as_many_bits_as_most_rings_have_room_for() -> None:
    mesh = Mesh(*hoop())
    surface, precision = weld(mesh), precision_of(mesh)
    chosen = plan(surface, KEY, precision)
    assert chosen.covered > 0.95
    assert len(chosen.marks) > 0.25 * len(mesh.vertices)
    done = mark(chosen, KEY, ID, _symbols)
    marked = Mesh(done.points.astype(np.float32).astype(np.float64), mesh.faces)
    found = _check(marked)
    assert found.nonce == ID
    assert not altered_points(weld(marked), found).any()
    assert found.verified.mean() > 0.95


def test_the_even_rings_of_a_subdivided_surface_carry_coarse_marks() -> None:
    mesh = ATTACKS["loop"].apply(Mesh(*pebble(40)), 2, np.random.default_rng(0), Given()).mesh
    (group,) = [
        rings for rings in ordered_rings(mesh.faces, len(mesh.vertices)) if rings.around.shape[1] == 6
    ]
    shapes = ring_shapes(mesh.vertices, group)
    coarse = float(np.median(shapes.size / shapes.spread)) / 2.0**5  # level 10
    even = (shapes.spread < 3.2) & (np.abs(level_of(shapes, coarse) - 10.0) < 1.0)
    assert even.sum() > 2000
    assert (room(shapes, coarse)[even] > 0.0).mean() > 0.8


def test_a_surface_without_faces_has_no_marks() -> None:
    found = _check(Mesh(ORIGINAL.vertices, np.empty((0, 3), np.int64)))
    assert found.nonce is None
    assert not any(
        getattr(found, field.name).any()
        for field in some(fields(found))
        if isinstance(getattr(found, field.name), np.ndarray)
    )
    assert found.log10_chance == 0.0


def test_precision_is_that_of_the_file_and_of_benign_exports() -> None:
    mesh = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    assert 0.5e-6 <= precision_of(mesh) <= 1e-6
    small = Mesh(mesh.vertices * 0.1, mesh.faces)
    assert precision_of(small) == 0.5e-6
    large = Mesh(mesh.vertices * 1e4, mesh.faces)
    assert precision_of(large) >= 1e4 * 2.0**-24
    assert precision_of(mesh, "tolerant") >= 2.0**-17
    stray = np.concatenate([mesh.vertices, [[1e6, 1e6, 1e6]]])
    for tolerance in (None, "strict"):
        assert precisions_of(Mesh(stray, mesh.faces), tolerance) == precisions_of(mesh, tolerance)
    far = precisions_of(Mesh(mesh.vertices + 1e5, mesh.faces))
    assert far[-2].error >= 1e5 * 2.0**-24
    assert far[-1].error == pytest.approx(precisions_of(mesh)[-1].error, rel=0.5)
    assert far[-1].remark is not None
    with pytest.raises(InputError, match="strict, default, tolerant"):
        precision_of(mesh, "loose")


def test_marks_too_sparse_for_a_reader_are_refused():
    (fine, fine_faces), (coarse, coarse_faces) = pebble(130), pebble(18)
    alone = Mesh(coarse, coarse_faces)
    beside = Mesh(
        np.concatenate([coarse, 0.05 * fine + 9.0]), np.concatenate([coarse_faces, fine_faces + len(coarse)])
    )
    assert 40 <= len(plan(weld(alone), KEY, 2e-5).marks) < 84
    with pytest.raises(CapacityError, match="needs 85"):  # 1 % of the points of both
        plan(weld(beside), KEY, 2e-5)


def test_of_few_rings_a_reader_looks_at_all(monkeypatch):
    monkeypatch.setattr("meshmark.authentication.marks.plan.SPARSEST", 1.0)
    assert len(plan(weld(Mesh(*pebble(40))), KEY, 1e-6).marks) < 820  # of 820 rings
    with pytest.raises(CapacityError, match="too few points"):
        plan(weld(Mesh(*pebble(50))), KEY, 1e-6)
