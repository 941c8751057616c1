"""With the original at hand altered parts come back vertex for vertex, as they were signed off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshmark.authentication.examination import examine
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.similarity import Similarity, rotation_of
from meshmark.marking import authenticate, marked_again, original_recovery, recover
from meshmark.mesh import Mesh
from tests.keys import KEY
from tests.marked import marked_pebble
from tests.shapes import pebble

POSE = Similarity(scale=2.5, rotation=rotation_of(np.array([0.3, 1.0, 0.4])), shift=np.array([3.0, 4.0, 5.0]))


def original() -> Mesh:
    return Mesh(*pebble(58))


def bumped() -> tuple[Mesh, np.ndarray]:
    """The marked pebble with an end pulled out, and which vertices that moved."""
    marked = marked_pebble().mesh
    bump = marked.vertices[:, 0] > np.quantile(marked.vertices[:, 0], 0.92)
    return marked.with_vertices(np.where(bump[:, None], 1.05 * marked.vertices, marked.vertices)), bump


def test_a_turned_cropped_and_edited_copy_comes_back_as_it_was_signed_off(monkeypatch):
    monkeypatch.setattr(
        marked_again, "embed_for", lambda *_: marked_pebble()
    )  # it takes seconds to say the same
    edited, _ = bumped()
    order = np.random.default_rng(0).permutation(len(edited.vertices))
    places = POSE(edited.vertices[order]).astype(np.float32).astype(float)
    kept = places[:, 0] < np.quantile(places[:, 0], 0.85)
    faces = np.argsort(order)[edited.faces]
    suspect = Mesh(places[kept], (np.cumsum(kept) - 1)[faces[kept[faces].all(axis=1)]])
    found = recover(suspect, KEY, original=original(), reference=marked_pebble().certificate)
    assert found.restored_from == "marked_copy"
    assert authenticate(found.mesh, KEY).verdict == "authentic"
    truth = POSE(marked_pebble().mesh.vertices)
    off = kd_tree(found.mesh.vertices).query(truth)[0]
    assert off.max() < 1e-6 * np.linalg.norm(np.ptp(truth, axis=0))
    assert found.mesh.faces.shape == edited.faces.shape
    stayed = (found.mesh.vertices[: kept.sum()] == suspect.vertices).all(axis=1)
    assert found.vertices_moved == (~stayed).sum()
    assert stayed.mean() > 0.85
    assert found.intact_rms_over_diagonal < 1e-7


def no_room(*_: object) -> None:
    raise CapacityError("no room")


def test_parts_of_the_original_come_back_where_the_marked_copy_cannot_be_made_again(monkeypatch):
    monkeypatch.setattr(marked_again, "embed_for", no_room)
    edited, bump = bumped()
    found = recover(edited, KEY, original=original())
    assert found.restored_from == "original"
    assert "carry no mark" in found.advice
    off = np.linalg.norm(found.mesh.vertices - original().vertices, axis=1)
    assert off[bump].max() < 2e-3 * np.linalg.norm(np.ptp(edited.vertices, axis=0))
    stayed = (found.mesh.vertices == edited.vertices).all(axis=1)
    assert stayed[~bump].mean() > 0.97


def test_another_original_does_not_fit(monkeypatch):
    monkeypatch.setattr(marked_again, "embed_for", no_room)
    found = recover(bumped()[0], KEY, original=Mesh(*pebble(40)))
    assert found.mesh is None
    assert found.advice.startswith("The original does not fit")


def test_without_a_mark_nothing_is_recovered(monkeypatch):
    unread = replace(examine(bumped()[0], KEY), id=None)
    monkeypatch.setattr(original_recovery, "examine", lambda *_: unread)
    found = recover(bumped()[0], KEY, original=original())
    assert found.mesh is None
    assert found.advice == "No mark of this key was found."


def test_the_marked_copy_serves_as_well_as_the_original_and_not_beside_it():
    edited, bump = bumped()
    found = recover(edited, KEY, copy=marked_pebble().mesh)
    assert (found.restored_from, found.vertices_moved) == ("marked_copy", bump.sum())
    assert np.array_equal(found.mesh.vertices, marked_pebble().mesh.vertices)
    assert recover(edited, KEY, copy=Mesh(*pebble(40))).advice.startswith("The marked copy does not fit")
    with pytest.raises(InputError, match="exclude each other"):
        recover(edited, KEY, copy=marked_pebble().mesh, original=original())
