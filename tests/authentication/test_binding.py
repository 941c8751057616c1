from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from meshmark import authenticate, extract, recover, unmark
from meshmark.certificate.binding import FIELD, bound, mismatch, refuse_edited, stated_id
from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certify import certify
from meshmark.coding.keys import Key
from meshmark.coding.message import PRESENCE, SHORT_IDS
from meshmark.errors import InputError
from meshmark.marking.undo import sealed
from meshmark.mesh import Mesh
from tests.keys import KEY
from tests.shapes import pebble

MESH = Mesh(*pebble(24))


@pytest.fixture(scope="module")
def values(tmp_path_factory) -> dict[str, Any]:
    """The fields of a certificate's file."""
    path = tmp_path_factory.mktemp("binding") / "model.cert"
    certificate = certify(MESH, 0.25, 0.06, "standard")
    certificate.more["layers"] = "both"
    sealed(certificate, MESH, MESH, KEY, 7).save(path)
    return json.loads(path.read_text())


def loaded(values: dict[str, Any], tmp_path) -> Certificate:
    path = tmp_path / "edited.cert"
    path.write_text(
        json.dumps(values).replace("Infinity", "1e999")
    )  # what is not JSON, as JSON that reads the same
    return Certificate.load(path)


def edited(change: Callable[[dict[str, Any]], object], values: dict[str, Any], tmp_path) -> Certificate:
    copy = json.loads(json.dumps(values))
    change(copy)
    return loaded(copy, tmp_path)


def swapped(text: str) -> str:
    """Return an array in base64 in which two bytes of the first mantissa are exchanged for others."""
    return ("B" if text[0] == "A" else "A") + text[1:]


EDITS: dict[str, Callable[[dict[str, Any]], object]] = {
    "spacing": lambda v: v.update(spacing=0.26),
    "step": lambda v: v.update(step=0.0600000001),
    "strength": lambda v: v.update(strength="subtle"),
    "vertices": lambda v: v.update(vertices=v["vertices"] + 1),
    "faces": lambda v: v.update(faces=v["faces"] + 1),
    "layers": lambda v: v.update(layers="ownership"),
    "no layers": lambda v: v.pop("layers"),
    "one more": lambda v: v.update(note="mine"),
    "endless": lambda v: v.update(note=float("inf")),
    "centre": lambda v: v["frame"]["centre"].__setitem__(0, v["frame"]["centre"][0] + 1e-12),
    "scale": lambda v: v["frame"].update(scale=v["frame"]["scale"] * 1.001),
    "skewness": lambda v: v["frame"]["skewness"].__setitem__(1, 0.5),
    "places": lambda v: v["landmarks"].update(places=swapped(v["landmarks"]["places"])),
    "descriptors": lambda v: v["landmarks"].update(descriptors=swapped(v["landmarks"]["descriptors"])),
    "explains": lambda v: v["landmarks"].update(explains=0.5),
    "undo": lambda v: v["undo"].update(data=swapped(v["undo"]["data"])),
    "no undo": lambda v: v.pop("undo"),
    "id": lambda v: v[FIELD].update(id=swapped(v[FIELD]["id"])),
    "what is no id": lambda v: v[FIELD].update(id=7),
}


@pytest.mark.parametrize("name", EDITS)
def test_an_edited_field_is_refused(name, values, tmp_path):
    certificate = edited(EDITS[name], values, tmp_path)
    with pytest.raises(InputError, match="the certificate was edited after it was made"):
        refuse_edited(certificate, KEY)
    refuse_edited(certificate, Key(bytes(32)))  # of other keys' certificates nothing is known


def test_what_reads_with_a_certificate_refuses_an_edited_one(values, tmp_path):
    certificate = edited(EDITS["spacing"], values, tmp_path)
    for read in (
        lambda: extract(MESH, KEY, reference=certificate),
        lambda: authenticate(MESH, KEY, reference=certificate),
        lambda: recover(MESH, KEY, reference=certificate),
        lambda: unmark(MESH, KEY, certificate),
    ):
        with pytest.raises(InputError, match="the certificate was edited"):
            read()


def test_the_order_and_layout_of_the_file_do_not_matter(values, tmp_path):
    certificate = loaded(dict(reversed(values.items())), tmp_path)
    refuse_edited(certificate, KEY)
    assert mismatch(certificate, KEY, 7) is None
    assert mismatch(certificate, KEY, None) is None


def test_another_key_another_id_and_another_binding_are_told_apart(values, tmp_path):
    certificate = loaded(values, tmp_path)
    assert "another mark" in (mismatch(certificate, KEY, 8) or "")
    assert "another key" in (mismatch(certificate, Key(bytes(32)), 7) or "")
    for field in ("content", "key"):
        other = edited(lambda v, f=field: v[FIELD].update({f: "\ud800é"}), values, tmp_path)
        assert "another key, or its binding was changed" in (mismatch(other, KEY, 7) or "")
    for wrong in ("none", {}, {"content": 1, "key": 2}):
        other = edited(lambda v, w=wrong: v.update({FIELD: w}), values, tmp_path)
        refuse_edited(other, KEY)
        assert mismatch(other, KEY, 7) is not None


@pytest.mark.parametrize("identity", [0, 7, (1 << 64) - 1, SHORT_IDS + 3, PRESENCE])
def test_the_id_is_told_to_who_has_the_key(identity, values, tmp_path):
    made = bound(loaded(values, tmp_path), KEY, identity)
    assert stated_id(made, KEY) == identity
    assert stated_id(made, Key(bytes(32))) is None
    assert (
        made.more[FIELD]["id"] != bound(replace(made, faces=made.faces + 1), KEY, identity).more[FIELD]["id"]
    )


def test_a_certificate_of_before_tells_no_id(values, tmp_path):
    before = edited(lambda v: v[FIELD].pop("id"), values, tmp_path)
    refuse_edited(before, KEY)
    assert stated_id(before, KEY) is None
    assert mismatch(before, KEY, 7) is None


def test_the_length_of_a_sealed_id_does_not_tell_its_bits(values, tmp_path):
    certificate = loaded(values, tmp_path)
    ids = (7, SHORT_IDS + 3, PRESENCE)
    assert len({len(bound(certificate, KEY, each).more[FIELD]["id"]) for each in ids}) == 1


def test_a_field_nested_deeper_than_can_be_written_is_refused(values, tmp_path):
    deep: list[Any] = []
    for _ in range(100_000):
        deep = [deep]
    certificate = loaded(values, tmp_path)
    certificate.more["deep"] = deep
    with pytest.raises(InputError, match="nested too deeply"):
        refuse_edited(certificate, KEY)


def test_binding_is_random_to_who_has_no_key(values, tmp_path):
    certificate = loaded(values, tmp_path)
    fields = [bound(certificate, key, 7).more[FIELD] for key in (KEY, Key(bytes(32)))]
    fields.append(bound(certify(MESH, 0.3, 0.06, "standard"), KEY, 7).more[FIELD])
    words = [word for field in fields for word in field.values()]
    assert len(set(words)) == len(words) == 12
