from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certify import certify
from meshmark.errors import InputError, OutputError
from meshmark.mesh import Mesh
from tests.geometry.registering import lump

LABEL = "0123456789abcdef" * 2
ARRAYS = ("places", "normals", "masses", "curvatures", "descriptors")


@pytest.fixture(scope="module")
def certificate() -> Certificate:
    return certify(Mesh(*lump(48)), 0.25, 0.06, "standard", lattice=LABEL)


@pytest.fixture
def values(certificate, tmp_path) -> dict:
    certificate.save(tmp_path / "good.json")
    return json.loads((tmp_path / "good.json").read_text())


def test_a_saved_certificate_loads_as_the_same(certificate, tmp_path):
    path = tmp_path / "model.certificate"
    certificate.save(path)
    again = Certificate.load(path)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(again.landmarks, name), getattr(certificate.landmarks, name))
    for name in ("centre", "axes", "moments", "skewness"):
        np.testing.assert_array_equal(getattr(again.frame, name), getattr(certificate.frame, name))
    assert (again.frame.scale, again.frame.area) == (certificate.frame.scale, certificate.frame.area)
    assert again.landmarks.explains == certificate.landmarks.explains
    assert (again.spacing, again.step, again.strength, again.lattice) == (0.25, 0.06, "standard", LABEL)
    assert (
        (again.vertices, again.faces)
        == (certificate.vertices, certificate.faces)
        == (len(lump(48)[0]), len(lump(48)[1]))
    )
    assert path.stat().st_size < 100_000


def test_the_same_mesh_gives_the_same_file(certificate, tmp_path):
    certificate.save(tmp_path / "one")
    certify(Mesh(*lump(48)), 0.25, 0.06, "standard", lattice=LABEL).save(tmp_path / "other")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()


def test_fields_of_later_versions_are_kept(values, tmp_path):
    (tmp_path / "more").write_text(json.dumps({**values, "digests": [1, 2]}))
    read = Certificate.load(tmp_path / "more")
    assert read.more == {"carriers": "cells", "corners": values["corners"], "digests": [1, 2]}
    read.save(tmp_path / "again")
    assert Certificate.load(tmp_path / "again").more == read.more


def test_it_says_that_the_id_lies_in_points_and_keeps_corners(tmp_path):
    told = certify(Mesh(*lump(48)), 0.25, 0.06, "standard", lattice=LABEL, at_points=True)
    told.save(tmp_path / "a.cert")
    read = Certificate.load(tmp_path / "a.cert")
    assert read.at_points
    assert read.corners.shape == (100, 3, 3)
    np.testing.assert_array_equal(read.corners, told.corners)


def test_it_says_that_the_id_lies_in_cells(certificate):
    assert certificate.more["carriers"] == "cells"
    assert not certificate.at_points


@pytest.mark.parametrize("text", ["?", "AAAA", None, 7])
def test_corners_that_are_none_are_refused(certificate, text):
    broken = replace(certificate, more={"carriers": "points", "corners": text})
    with pytest.raises(InputError, match="corners"):
        _ = broken.corners


def test_no_vertex_of_the_surface_is_in_it(certificate):
    points, _ = lump(48)
    places = certificate.frame.to_scene(certificate.landmarks.places)
    gaps = np.linalg.norm(places[:, None] - points, axis=2).min(axis=1)
    assert gaps.min() > 0.0
    assert np.median(gaps) > 1e-3


BROKEN = {
    "no JSON": b"certificate\n",
    "not finite": b'{"format": NaN}',
    "deep": b"[" * 100_000,
    "no object": b"[]",
    "another format": b'{"format": "meshmark key 1"}',
    "no text": bytes(range(256)),
    "empty": b"",
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_no_certificate_is_refused(name, tmp_path):
    path = tmp_path / "bad"
    path.write_bytes(BROKEN[name])
    with pytest.raises(InputError, match="is not a meshmark certificate: "):
        Certificate.load(path)


CHANGES = {
    "version": (("version",), 5, "its version is 5, expected 4"),
    "strength": (("strength",), "huge", "unknown strength 'huge', expected one of subtle"),
    "spacing": (("spacing",), -1.0, "'spacing' is out of range, expected"),
    "lattice": (("lattice",), "0" * 31, "'lattice' is missing or not 32 hexadecimal digits"),
    "capitals": (("lattice",), "A" * 32, "'lattice' is missing or not"),
    "step": (("step",), True, "'step' is missing or no number"),
    "vertices": (("vertices",), 1.5, "'vertices' is missing or no whole number"),
    "landmarks": (("landmarks",), [], "'landmarks' is missing or no object"),
    "count": (("landmarks", "count"), 3, "'places' holds"),
    "base64": (("landmarks", "masses"), "?", "'masses' is not an array in base64"),
    "scale": (("frame", "scale"), 0.0, "'scale' is out of range, expected"),
    "axes": (("frame", "axes"), [[1, 0, 0], [0, 1, 0], [0, 0, -1]], "'axes' is not a rotation"),
    "centre": (("frame", "centre"), [1, 2], "'centre' is missing, or not 3 finite numbers"),
    "no name": (("strength",), ["subtle"], "unknown strength"),
    "true": (("version",), True, "its version is True, expected 4"),
    "large": (("faces",), 10**400, "'faces' is out of range"),
    "large scale": (("frame", "scale"), 10**400, "'scale' is out of range"),
    "big": (("frame", "centre"), [1, 2, 10**400], "'centre' is missing, or not 3 finite numbers"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_field_that_is_wrong_is_named(name, values, tmp_path):
    where, value, message = CHANGES[name]
    place = values
    for step in where[:-1]:
        place = place[step]
    place[where[-1]] = value
    (tmp_path / "bad").write_text(json.dumps(values))
    with pytest.raises(InputError, match=f"bad is not a meshmark certificate: {message}"):
        Certificate.load(tmp_path / "bad")


@pytest.mark.parametrize("version", [1, 2, 3])
def test_an_older_version_is_refused_in_one_sentence(version, values, tmp_path):
    (tmp_path / "old").write_text(json.dumps({**values, "version": version}))
    with pytest.raises(
        InputError, match=f"old is a certificate of version {version}, expected 4: marks of earlier versions"
    ) as told:
        Certificate.load(tmp_path / "old")
    assert "is not a meshmark certificate" not in str(told.value)


@pytest.mark.parametrize("array", ARRAYS)
def test_arrays_without_sense_are_refused(array, values, tmp_path):
    text = values["landmarks"][array]
    values["landmarks"][array] = "/" * len(text.rstrip("=")) + "=" * (
        len(text) - len(text.rstrip("="))
    )  # NaN
    (tmp_path / "bad").write_text(json.dumps(values))
    with pytest.raises(InputError, match="is not a meshmark certificate: "):
        Certificate.load(tmp_path / "bad")


def test_files_that_cannot_be_read_or_written(certificate, tmp_path):
    with pytest.raises(InputError, match="cannot read the certificate"):
        Certificate.load(tmp_path / "absent")
    with pytest.raises(OutputError, match="cannot write"):
        certificate.save(tmp_path / "absent" / "file")


def test_a_mesh_without_surface_has_no_certificate():
    with pytest.raises(InputError):
        certify(Mesh(np.eye(3), np.array([[0, 1, 1]])), 0.25, 0.06, "standard")
