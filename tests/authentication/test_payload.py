from __future__ import annotations

import numpy as np
import pytest

from meshmark.authentication.payload.content import content_for, content_of
from meshmark.authentication.payload.payload import (
    KINDS,
    Payload,
    capacity,
    decode,
    encoder,
    pack,
    unpack,
)
from meshmark.authentication.payload.signed_totals import whole_of
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.shapes import pebble


@pytest.mark.parametrize("kind", KINDS)
def test_packing_round_trips(kind):
    content = b"" if kind == "none" else bytes(range(256))
    assert unpack(pack(kind, content)) == Payload(kind=kind, content=content)


@pytest.mark.parametrize("intact", [0.4, 0.55, 1.0])
def test_what_capacity_promises_is_read_from_that_share_of_the_marks(intact):
    marks, bits = 900, 9
    content = np.random.default_rng(1).bytes(capacity(marks, bits, intact))
    source = encoder(pack("image", content), bits, marks)
    index = np.random.default_rng(2).integers(0, 1 << 32, marks, dtype=np.uint32)[: int(intact * marks)]
    packed = decode(index, source(index), bits)
    assert packed is not None
    assert unpack(packed) == Payload(kind="image", content=content)


def test_what_cannot_be_is_refused():
    with pytest.raises(InputError, match="unknown payload 'song'"):
        pack("song", b"")
    with pytest.raises(InputError, match="expected no content"):
        pack("none", b"x")
    with pytest.raises(InputError, match="newer meshmark"):
        unpack(b"\xff123")
    with pytest.raises(InputError, match="newer meshmark"):
        unpack(b"")
    with pytest.raises(InputError, match="out of range"):
        capacity(100, 8, 0.0)
    with pytest.raises(CapacityError, match="for 100 mark vertices"):
        encoder(pack("bytes", bytes(500)), 8, 100)


def test_few_marks_carry_nothing():
    assert capacity(10, 8) == 0


@pytest.mark.parametrize("symbols", [30, 80])
def test_only_a_miniature_that_was_asked_for_is_refused_where_it_does_not_fit(symbols):
    surface = weld(Mesh(*pebble(24)))
    whole = whole_of(surface, 1e-6)
    packed, remarks = content_for(content_of(None), surface, whole, (symbols, 8))
    assert unpack(packed).whole.points == whole.points
    assert unpack(packed).kind == "none"
    assert len(remarks) == 1
    assert "no payload" in remarks[0]
    with pytest.raises(CapacityError, match="a miniature of the model does not fit"):
        content_for(content_of("miniature"), surface, whole, (symbols, 8))
