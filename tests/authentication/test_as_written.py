"""What a model with the id alone tells of alterations: nothing by itself, more with its certificate."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import meshmark as mm
from meshmark.authentication.as_written import FIELD, Since, since_written
from meshmark.certificate import binding
from meshmark.coding.keyed import rotation
from meshmark.coding.keys import Key
from meshmark.errors import CapacityError, InputError
from meshmark.marking import Certificate, authenticate, embed
from meshmark.mesh import Mesh
from tests.keys import ID, KEY, OTHER
from tests.marked import marked_pebble
from tests.shapes import pebble

CANNOT_TELL = "whether it was changed cannot be told"


@pytest.fixture(scope="module")
def marked():
    return marked_pebble(layers="ownership")


@pytest.fixture(scope="module")
def certificate(marked, tmp_path_factory):
    """Return the certificate as its file holds it."""
    path = tmp_path_factory.mktemp("certificate") / "a.cert"
    marked.certificate.save(path)
    return Certificate.load(path)


def rounded(mesh: Mesh, bits: int) -> Mesh:
    """Return a mesh on a grid of so many bits along its longest side."""
    low = mesh.vertices.min(axis=0)
    step = np.ptp(mesh.vertices, axis=0).max() / (2**bits - 1)
    return mesh.with_vertices(np.round((mesh.vertices - low) / step) * step + low)


@pytest.mark.parametrize("number", range(0, 6, 2))
def test_a_file_as_written_is_never_called_altered_whatever_the_key(number):
    # Few points: the lock of an untouched mark is low here.
    mesh = Mesh(*pebble(26 + 4 * number))
    key = Key(bytes([number]) * 32)
    result = embed(mesh, key, id=ID + number, layers="ownership", strength="strong")
    found = authenticate(result.mesh, key)
    assert (found.verdict, found.id, found.altered_vertices) == ("inconclusive", ID + number, 0)
    assert CANNOT_TELL in found.advice
    assert authenticate(result.mesh, key, reference=result.certificate).verdict == "authentic"


def test_the_certificate_knows_the_file_that_was_written(marked, certificate):
    found = authenticate(marked.mesh, KEY, reference=certificate)
    assert (found.verdict, found.id, found.altered_vertices) == ("authentic", ID, 0)
    assert "its positions and faces are those that its certificate was made for" in found.advice
    nudged = marked.mesh.vertices.copy()
    nudged[7, 1] = np.nextafter(nudged[7, 1], 9.0)
    assert since_written(certificate, marked.mesh.with_vertices(nudged), KEY) is Since.UNKNOWN
    fewer = Mesh(marked.mesh.vertices, marked.mesh.faces[:-1])
    assert since_written(certificate, fewer, KEY) is Since.UNKNOWN
    assert since_written(certificate, marked.mesh, OTHER) is not Since.SAME


def test_rounding_turning_and_another_order_prove_no_change(marked, certificate):
    mesh = marked.mesh
    turned = 3.0 * mesh.vertices @ rotation(b"a" * 32).T + [7.0, -2.0, 1.0]
    order = np.random.default_rng(1).permutation(len(mesh.vertices))
    copies = [
        mesh.with_vertices(turned.astype(np.float32).astype(np.float64)),
        rounded(mesh, 16),
        mesh.with_vertices(np.round(mesh.vertices, 6)),
        Mesh(mesh.vertices[order], np.argsort(order)[mesh.faces]),
    ]
    for copy in copies:
        found = authenticate(copy, KEY, reference=certificate)
        assert (found.verdict, found.id) == ("inconclusive", ID)
        assert "no change shows" in found.advice


def test_a_change_that_the_id_feels_is_proven_by_the_certificate_only(marked, certificate):
    mesh = marked.mesh
    noise = 4e-4 * np.random.default_rng(2).normal(size=mesh.vertices.shape)
    bent = mesh.vertices.copy()
    near = np.linalg.norm(bent - bent[700], axis=1) < 0.35
    bent[near] *= 1.01
    for vertices in (mesh.vertices + noise * np.linalg.norm(np.ptp(mesh.vertices, axis=0)), bent):
        copy = mesh.with_vertices(vertices)
        known, blind = authenticate(copy, KEY, reference=certificate), authenticate(copy, KEY)
        assert (known.verdict, known.id, known.altered.all()) == ("altered", ID, True)
        assert "where it was changed cannot be told" in known.advice
        assert (blind.verdict, blind.id, blind.altered.any()) == ("inconclusive", ID, False)


def test_a_certificate_that_was_edited_is_refused(marked, tmp_path):
    path = tmp_path / "a.cert"
    marked.certificate.save(path)
    values = json.loads(path.read_text())
    for change in ({"layers": "both"}, {FIELD: {**values[FIELD], "lock": 1e3}}):
        path.write_text(json.dumps(values | change))
        with pytest.raises(InputError, match="the certificate was edited after it was made"):
            authenticate(rounded(marked.mesh, 16), KEY, reference=Certificate.load(path))


def test_a_certificate_without_the_lock_proves_nothing(marked, certificate):
    more = {name: value for name, value in certificate.more.items() if name not in (FIELD, binding.FIELD)}
    older = binding.bound(replace(certificate, more=more), KEY, ID)
    found = authenticate(marked.mesh, KEY, reference=older)
    assert (found.verdict, found.certificate) == ("inconclusive", "own")


def test_an_id_on_top_of_marks_that_would_call_it_altered_is_refused(model, monkeypatch):
    from meshmark.marking import both_layers

    first = embed(model, KEY, id=ID, layers="authentication", payload="none")
    below = both_layers.embed_repeated(model, KEY, id=ID + 1)
    # As where the id moves only a part of the surface: the other marks hold still.
    half = np.where(model.vertices[:, :1] > 0.0, first.mesh.vertices, below.mesh.vertices)
    monkeypatch.setattr(
        both_layers, "embed_repeated", lambda *_, **__: replace(below, mesh=Mesh(half, model.faces))
    )
    # No room for new marks: the id alone is left.
    monkeypatch.setattr("meshmark.marking.authentication_layer.plans", lambda *_, **__: iter(()))
    for asked in ("ownership", None):
        with pytest.raises(CapacityError, match="carries authentication marks of this key already"):
            embed(first.mesh, KEY, id=ID + 1, layers=asked)


def test_a_format_that_is_too_coarse_for_the_marks_is_refused(model, tmp_path, monkeypatch):
    from meshmark.marking import marked_file as files

    source, out = tmp_path / "a.ply", tmp_path / "b.ply"
    mm.write_mesh(model, source)
    read = files.read_mesh
    monkeypatch.setattr(
        files, "read_mesh", lambda path: read(path) if path == source else rounded(read(path), 9)
    )
    with pytest.raises(CapacityError, match=r"the marks of authentication cannot be read back from b\.ply"):
        files.embed_file(source, out, KEY, id=ID)
    assert not out.exists()
