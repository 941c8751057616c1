"""Models with plane sides keep them plane: cells beside them carry, or points that slide along them."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from meshmark.geometry.plane_patches import PlanePatches
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import VisibleChange
from meshmark.mesh import Mesh
from meshmark.ownership import embedding, embedding_in_points
from meshmark.ownership.embedding import embed
from meshmark.ownership.embedding_task import PLANE_OFF, EmbeddingTask
from meshmark.ownership.points.point_shaping import PointShaping
from tests.keys import ID, KEY
from tests.low_poly import box, joined, prism
from tests.shapes import boulder


def flat_and_round():
    """A rough boulder of 1,200 points on a broad slab."""
    return Mesh(*joined([boulder(50, 0.02), box((8, 8, 1), (3.0, 3.0, 0.3), (-1.5, -1.5, -1.9))]))


def off_plane(before: Mesh, after: Mesh) -> float:
    surface = surface_of(before)
    found = PlanePatches.of(surface.points, surface.faces)
    assert found.share > 0.1
    return found.off_plane(after.vertices[surface.vertex_of_point]) / surface.diagonal


@pytest.fixture(scope="module")
def mixed():
    return flat_and_round()


def test_cells_beside_the_planes_carry(mixed):
    made = embed(mixed, KEY, id=ID)
    assert not made.mark.at_points
    assert off_plane(mixed, made.mesh) <= PLANE_OFF
    slab = mixed.vertices[:, 2] <= -1.6
    assert (made.mesh.vertices[slab] == mixed.vertices[slab]).all()


def test_without_room_beside_them_points_carry(mixed, monkeypatch):
    monkeypatch.setattr(embedding, "_beside_planes", lambda _task: None)
    made = embed(mixed, KEY, id=ID)
    assert made.mark.at_points
    assert off_plane(mixed, made.mesh) <= PLANE_OFF


def test_a_column_of_flat_panels_stays_one():
    column = Mesh(*prism(30, 6, 6.0))
    assert off_plane(column, embed(column, KEY, id=ID).mesh) <= PLANE_OFF


@pytest.fixture(scope="module")
def blocks():
    """Turned boxes, all of whose 256 points are corners of three planes."""
    rng = np.random.default_rng(3)
    points, faces = box((1, 1, 1), (2.0, 2.0, 2.0), (-1.0, -1.0, -1.0))
    parts = []
    for place in product(range(4), range(4), range(2)):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        size = rng.uniform(0.2, 0.4, size=3)
        parts.append((points * size @ turn + np.array(place) * [1.0, 1.3, 1.7], faces))
    return Mesh(*joined(parts))


def test_corners_of_many_planes_take_them_along(blocks):
    made = embed(blocks, KEY, id=ID)
    assert made.mark.at_points
    assert off_plane(blocks, made.mesh) <= PLANE_OFF


@pytest.mark.parametrize("seed", [5, 7])
def test_boxes_along_the_axes_stay_boxes(seed):
    """24 boxes on a shelf: their corners slide along no direction, and are as easily moved along each axis."""
    rng = np.random.default_rng(seed)
    parts = []
    for place in product(range(6), range(4)):
        low = np.array([*place, 0.0]) * [1.0, 1.3, 1.7] + rng.uniform(0.0, 0.3, 3)
        parts.append(box((1, 1, 1), rng.uniform(0.3, 0.7, 3), low))
    shelf = Mesh(*joined(parts))
    made = embed(shelf, KEY, id=ID)
    assert made.mark.at_points
    assert off_plane(shelf, made.mesh) <= PLANE_OFF


def test_slivers_as_wide_as_a_rounding_do_not_matter(blocks):
    strip = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 6.1e-17, 0.0], [0.5, 6.1e-17, 0.0]])
    parts = [(blocks.vertices, blocks.faces), (strip, np.array([[0, 1, 3], [0, 3, 2]]))]
    model = Mesh(*joined(parts))
    assert off_plane(model, embed(model, KEY, id=ID).mesh) <= PLANE_OFF


@pytest.mark.parametrize(("weak", "tried"), [(0.0, [True]), (2.0, [True, False])])
def test_planes_may_bend_where_they_leave_little_room(blocks, monkeypatch, weak, tried):
    kept = []

    class Noted(PointShaping):
        def __init__(self, *given, planes, **named):
            kept.append(planes is not None)
            super().__init__(*given, planes=planes, **named)

    monkeypatch.setattr(embedding_in_points, "PointShaping", Noted)
    monkeypatch.setattr(embedding_in_points, "WEAK", weak)
    assert embed(blocks, KEY, id=ID).mark.at_points
    assert kept == tried


def test_parts_where_every_mark_is_seen_are_left_alone(blocks, monkeypatch):
    ever_made = embedding_in_points._made

    def seen_without_rest(task, shaping, choice):
        return ever_made(task, shaping, choice) if shaping._still.any() else None

    def on_the_left(_self, points):
        return points[:, 0] < np.quantile(points[:, 0], 0.2)

    monkeypatch.setattr(embedding_in_points, "_made", seen_without_rest)
    monkeypatch.setattr(VisibleChange, "seen", on_the_left)
    made = embed(blocks, KEY, id=ID)
    moved = (made.mesh.vertices != blocks.vertices).any(axis=1)
    left = blocks.vertices[:, 0] < np.quantile(blocks.vertices[:, 0], 0.15)
    assert left.sum() > 20
    assert not moved[left].any()
    assert moved[~left].mean() > 0.5
    assert made.mark.at_points


def test_a_model_is_marked_where_its_planes_cannot_be_kept(blocks, monkeypatch):
    shaped = PointShaping.shaped
    monkeypatch.setattr(
        PointShaping, "shaped", lambda self, choice: None if self._patches else shaped(self, choice)
    )
    made = embed(blocks, KEY, id=ID)
    assert made.mark.at_points
    assert off_plane(blocks, made.mesh) > PLANE_OFF


def test_large_models_keep_the_tougher_mark(mixed, monkeypatch):
    monkeypatch.setattr(embedding, "SMALL", 100)
    monkeypatch.setattr(embedding, "TOUGH", 1e9)
    made = embed(mixed, KEY, id=ID)
    assert not made.mark.at_points
    task = EmbeddingTask(mesh=mixed, key=KEY, identity=ID, strength="standard", rms=8e-4)
    assert task.has_planes
    assert not task.keeps_planes(made.mesh)


def test_cells_that_bear_no_noise_give_way_to_points(monkeypatch):
    rough = Mesh(*boulder(40, 0.02))
    assert not embed(rough, KEY, id=ID).mark.at_points
    monkeypatch.setattr(embedding, "FIRM", 1e9)
    monkeypatch.setattr(embedding, "FRAIL_NOISE", 2e-2)
    assert embed(rough, KEY, id=ID).mark.at_points
