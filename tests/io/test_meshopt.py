"""meshopt streams decode to what the reference decoder gives, and broken ones are refused."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.errors import FormatError
from meshmark.io.gltf.codecs import decode
from meshmark.io.gltf.meshopt_index import decode_sequence, decode_triangles
from meshmark.io.gltf.meshopt_vertex import decode_vertices
from tests.counting import Share, some
from tests.io.compressed_samples import STREAMS, bytes_of, meshopt_rows, meshopt_triangles


def rows(stream: list[Any], data: bytes | None = None) -> np.ndarray:
    mode, filter_, count, stride, *_ = stream
    given = bytes_of(stream) if data is None else data
    return decode(given, "meshopt", mode=mode, count=count, stride=stride, filter=filter_)["rows"]


@pytest.mark.parametrize("stream", STREAMS, ids=lambda item: " ".join(map(str, item[:4])))
def test_streams_of_the_reference_encoder(stream: list[Any]) -> None:
    found = rows(stream)
    assert found.shape == (stream[2], stream[3])
    assert hashlib.sha256(found.tobytes()).hexdigest()[:16] == stream[5]


def test_the_streams_cover_all_modes_filters_and_versions() -> None:
    assert {(item[0], item[1]) for item in STREAMS} == {
        *(("ATTRIBUTES", name) for name in ("NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR")),
        ("TRIANGLES", "NONE"),
        ("INDICES", "NONE"),
    }
    assert {bytes_of(item)[0] for item in STREAMS} == {0xA0, 0xA1, 0xD1, 0xE1}


@settings(max_examples=60, deadline=None)
@given(count=st.integers(1, 600), lanes=st.integers(1, 9), seed=st.integers(0, 99))
def test_rows_written_here_come_back(count: int, lanes: int, seed: int) -> None:
    original = np.random.default_rng(seed).integers(0, 256, (count, 4 * lanes)).astype(np.uint8)
    assert np.array_equal(decode_vertices(meshopt_rows(original), count, 4 * lanes), original)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(0, 2**32 - 1), min_size=1, max_size=30))
def test_triangles_written_here_come_back(values: list[int]) -> None:
    original = np.array(values * 3)
    assert np.array_equal(decode_triangles(meshopt_triangles(original), len(original)), original)


def test_broken_streams_are_decoded_or_refused() -> None:
    with Share(0.1) as share:
        break_streams(share)


@settings(max_examples=200, deadline=None)
@given(
    stream=st.sampled_from(STREAMS),
    edits=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=6),
    data=st.data(),
)
def break_streams(share: Share, stream: list[Any], edits: Any, data: st.DataObject) -> None:
    changed = bytearray(bytes_of(stream))
    for place, value in edits:
        changed[place % len(changed)] = value
    cut = data.draw(st.integers(0, len(changed)))
    for broken in (bytes(changed), bytes(changed[:cut])):
        share.case()
        try:
            found = rows(stream, broken)
        except FormatError:
            continue
        share.asserted()
        assert found.shape == (stream[2], stream[3])


def test_streams_of_other_lengths_are_refused() -> None:
    for stream in some(STREAMS):
        for data in (bytes_of(stream)[:-1], bytes_of(stream) + b"\0", b""):
            with pytest.raises(FormatError):
                rows([*stream[:2], stream[2] + 48, *stream[3:]], data)
    with pytest.raises(FormatError, match="header byte"):
        decode_sequence(b"\xe1" + bytes(20), 3)
    with pytest.raises(FormatError, match="header byte"):
        decode_triangles(b"\xd1" + bytes(20), 3)
    with pytest.raises(FormatError, match="QUATERNION does not take rows of 4"):
        rows(["ATTRIBUTES", "QUATERNION", 1, 4], b"\xa0")
