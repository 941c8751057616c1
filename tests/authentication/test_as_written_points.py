"""What the certificate of an id in points tells of alterations."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.as_written import FIELD, Since, since_written
from meshmark.authentication.written_lock import reader_of
from meshmark.coding.keyed import rotation
from meshmark.geometry.surface_of import surface_of
from meshmark.marking import Certificate, authenticate, embed
from meshmark.mesh import Mesh
from tests.counting import some
from tests.keys import ID, KEY, OTHER
from tests.low_poly import ball, box, soup

SHAPES = {"box": box((6, 5, 4), (3.0, 2.0, 1.3)), "ball": ball(1)}


@pytest.fixture(scope="module", params=SHAPES)
def result(request):
    found = embed(Mesh(*SHAPES[request.param]), KEY, id=ID, layers="ownership")
    assert found.ownership.at_points
    return found


@pytest.fixture(scope="module")
def certificate(result, tmp_path_factory) -> Certificate:
    """Return the certificate as its file holds it."""
    path = tmp_path_factory.mktemp("certificate") / "a.cert"
    result.certificate.save(path)
    return Certificate.load(path)


def test_a_file_as_written_is_the_same(result, certificate):
    assert certificate.at_points
    assert since_written(certificate, result.mesh, KEY) is Since.SAME
    found = authenticate(result.mesh, KEY, reference=certificate)
    assert (found.verdict, found.id, found.altered_vertices) == ("authentic", ID, 0)
    blind = authenticate(result.mesh, KEY)
    assert (blind.verdict, blind.id) == ("inconclusive", ID)


def test_rounding_turning_and_another_order_prove_no_change(result, certificate):
    mesh = result.mesh
    order = np.random.default_rng(1).permutation(len(mesh.vertices))
    turned = 3.0 * mesh.vertices @ rotation(b"a" * 32).T + [7.0, -2.0, 1.0]
    copies = [
        mesh.with_vertices(turned.astype(np.float32).astype(float)),
        mesh.with_vertices(np.round(mesh.vertices, 5)),
        Mesh(mesh.vertices[order], np.argsort(order)[mesh.faces]),
        soup(mesh),
    ]
    for copy in some(copies):
        assert since_written(certificate, copy, KEY) is Since.UNKNOWN
    assert authenticate(copies[0], KEY, reference=certificate).verdict == "inconclusive"


def test_one_last_bit_is_enough_not_to_be_the_same(result, certificate):
    nudged = result.mesh.vertices.copy()
    nudged[7, 1] = np.nextafter(nudged[7, 1], 9.0)
    assert since_written(certificate, result.mesh.with_vertices(nudged), KEY) is Since.UNKNOWN
    assert since_written(certificate, result.mesh, OTHER) is not Since.SAME


def test_noise_that_the_lock_feels_is_a_change(result, certificate):
    mesh = result.mesh
    diagonal = np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    noise = 1.5e-3 * diagonal * np.random.default_rng(2).normal(size=mesh.vertices.shape)
    assert since_written(certificate, mesh.with_vertices(mesh.vertices + noise), KEY) is Since.CHANGED


def test_the_unmarked_model_is_a_change(result, certificate):
    name = next(
        each
        for each in SHAPES
        if len(SHAPES[each][0]) == len(result.mesh.vertices)
        and np.array_equal(SHAPES[each][1], result.mesh.faces)
    )
    assert since_written(certificate, Mesh(*SHAPES[name]), KEY) is Since.CHANGED


def test_the_lock_that_was_written_is_that_of_the_mark(result, certificate):
    lock = reader_of(surface_of(result.mesh), KEY, certificate).best()
    written = certificate.more[FIELD]
    assert (written["carriers"], written["lock"]) == (len(lock.phase), pytest.approx(lock.score))
    assert lock.score > 0.5 * len(lock.phase)
    assert lock.agreement(lock) == pytest.approx(1.0)
    wrong = reader_of(surface_of(result.mesh), OTHER, certificate).best()
    assert wrong.score < 0.3 * len(wrong.phase)
    assert wrong.agreement(lock) < 0.5
