"""A file whose surface is intact and that shows something else is never authentic; lawful changes leave it so."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import meshmark as mm
from meshmark.authentication.shown_otherwise import causes_of, packed_deviations
from meshmark.certificate.certificate import Certificate
from tests.glb_edits import (
    CHANGES,
    HARMLESS,
    Glb,
    added_lines,
    changed,
    clear_texture,
    glass,
    morph_weights,
    plain_glb,
    posed_skin,
    red,
)
from tests.keys import KEY
from tests.shapes import pebble

SHAPE = pebble(40)


class Marked(NamedTuple):
    """A marked GLB and its certificate."""

    data: bytes
    certificate: Certificate


def marked_glb(folder: Path, data: bytes) -> Marked:
    (folder / "in.glb").write_bytes(data)
    result = mm.embed_file(
        folder / "in.glb", folder / "out.glb", KEY, id=7, layers="authentication", payload="none"
    )
    return Marked((folder / "out.glb").read_bytes(), result.certificate)


@pytest.fixture(scope="module")
def marked(tmp_path_factory):
    return marked_glb(tmp_path_factory.mktemp("plain"), plain_glb(*SHAPE))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return what marks the model after a change, each once."""
    return cache(
        lambda change: marked_glb(tmp_path_factory.mktemp("made"), changed(plain_glb(*SHAPE), change))
    )


def judged(folder: Path, data: bytes, reference: Certificate | None = None) -> mm.Authentication:
    (folder / "suspect.glb").write_bytes(data)
    return mm.authenticate(mm.read_mesh(folder / "suspect.glb"), KEY, reference=reference)


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_each_change_of_what_is_shown_is_named(marked, tmp_path, change):
    found = judged(tmp_path, changed(marked.data, change))
    assert found.verdict == "surface_intact"
    assert [cause.kind for cause in found.causes] == [CHANGES[change]]
    assert found.causes[0].sentence[1:] in found.advice
    assert not found.altered.any()


@pytest.mark.parametrize("change", HARMLESS, ids=lambda change: change.__name__)
def test_what_shows_the_same_stays_authentic(marked, tmp_path, change):
    found = judged(tmp_path, changed(marked.data, change))
    assert (found.verdict, found.causes) == ("authentic", ())


def test_amounts_are_measured(marked, tmp_path):
    """A weight of 1 moves points by 1; a joint moved by 0.5 and another one at rest lie 0.25 off their mean."""
    morphed = judged(tmp_path, changed(marked.data, morph_weights)).causes[0]
    box = np.ptp(mm.read_mesh(tmp_path / "suspect.glb").vertices, axis=0)
    assert morphed.amount == pytest.approx(1.0 / np.linalg.norm(box), rel=1e-5)
    posed = judged(tmp_path, changed(marked.data, posed_skin)).causes[0]
    assert posed.amount == pytest.approx(0.25 / np.linalg.norm(box), rel=1e-5)


@pytest.mark.parametrize(
    ("change", "with_certificate"), [(morph_weights, False), (posed_skin, False), (glass, True)]
)
def test_what_was_so_when_it_was_signed_off_is_authentic(tmp_path, made, change, with_certificate):
    marked = made(change)
    reference = marked.certificate if with_certificate else None
    assert judged(tmp_path, marked.data, reference).verdict == "authentic"
    glb = Glb.read(marked.data)
    added_lines(glb)
    assert [cause.kind for cause in judged(tmp_path, glb.bytes(), reference).causes] == ["lines"]


def test_another_amount_is_another_thing(tmp_path, made):
    glb = Glb.read(made(morph_weights).data)
    glb.tree["meshes"][0]["weights"] = [1.5]
    assert judged(tmp_path, glb.bytes()).verdict == "surface_intact"
    glb.tree["meshes"][0]["weights"] = [1.02]  # as an export may round it
    assert judged(tmp_path, glb.bytes()).verdict == "authentic"
    glb.tree["meshes"][0]["weights"] = [0.0]  # the surface itself
    assert judged(tmp_path, glb.bytes()).verdict == "authentic"


def test_looks_are_compared_with_the_certificate_alone(marked, tmp_path):
    painted = changed(marked.data, red)
    assert judged(tmp_path, painted).verdict == "authentic"
    found = judged(tmp_path, painted, marked.certificate)
    assert found.verdict == "surface_intact"
    assert [cause.kind for cause in found.causes] == ["looks"]


def test_renamed_and_copied_materials_look_alike(tmp_path):
    made = marked_glb(tmp_path, changed(plain_glb(*SHAPE), red))
    glb = Glb.read(made.data)
    red(glb)  # a second material of the same looks
    glb.tree["materials"][-1] |= {"name": "blue", "doubleSided": False, "emissiveFactor": [0, 0, 0]}
    assert judged(tmp_path, glb.bytes(), made.certificate).verdict == "authentic"


def test_another_image_looks_different(tmp_path):
    made = marked_glb(tmp_path, changed(plain_glb(*SHAPE), clear_texture))
    assert judged(tmp_path, made.data, made.certificate).verdict == "authentic"
    glb = Glb.read(made.data)
    view = glb.tree["bufferViews"][glb.tree["images"][0]["bufferView"]]
    glb.blob[view["byteOffset"] + view["byteLength"] - 1] ^= 1
    assert judged(tmp_path, glb.bytes(), made.certificate).verdict == "surface_intact"


def test_an_altered_model_names_the_causes_too(marked, tmp_path):
    glb = Glb.read(changed(marked.data, morph_weights))
    accessor = glb.tree["accessors"][glb.primitive["attributes"]["POSITION"]]
    start = glb.tree["bufferViews"][accessor["bufferView"]]["byteOffset"]
    points = np.frombuffer(glb.blob, "<f4", 3 * accessor["count"], start).reshape(-1, 3).copy()
    points[np.linalg.norm(points - points[0], axis=1) < 0.4] += 0.05
    glb.blob[start : start + points.nbytes] = points.tobytes()
    found = judged(tmp_path, glb.bytes())
    assert found.verdict == "altered"
    assert [cause.kind for cause in found.causes] == ["morph_weights"]
    assert "Besides" in found.advice


def test_other_formats_show_what_they_hold(marked, tmp_path):
    (tmp_path / "marked.glb").write_bytes(marked.data)
    mesh = mm.read_mesh(tmp_path / "marked.glb")
    mm.write_mesh(mesh, tmp_path / "out.obj")
    assert mm.authenticate(mm.read_mesh(tmp_path / "out.obj"), KEY).verdict == "authentic"
    with (tmp_path / "out.obj").open("a") as file:
        file.write("l 1 2 3\n")
    found = mm.authenticate(mm.read_mesh(tmp_path / "out.obj"), KEY)
    assert found.verdict == "surface_intact"
    assert [cause.kind for cause in found.causes] == ["lines"]


def test_a_mesh_without_a_file_shows_its_surface():
    assert packed_deviations(None) == b""
    assert causes_of(None, KEY, None, None) == ()
