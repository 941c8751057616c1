"""The decoder's own process: what it returns, and that no stream takes more than its limits."""

from __future__ import annotations

import sys
from pathlib import Path

import DracoPy
import numpy as np
import pytest

from meshmark.errors import FormatError
from meshmark.io.gltf import streams as gltf_streams
from meshmark.io.gltf.streams import Stream, decode_streams
from tests.io.compressed_samples import STREAMS, bytes_of, draco_grid


def stream(item: list, **more: object) -> Stream:
    mode, filter_, count, stride, *_ = item
    given = {"mode": mode, "filter": filter_, "count": count, "stride": stride, **more}
    return Stream(
        where="bufferView 7", data=bytes_of(item), codec="meshopt", parameters=given, unpacked=count * stride
    )


def draco(data: bytes, ids: list[int]) -> Stream:
    return Stream(
        where="mesh 1, primitive 2", data=data, codec="draco", parameters={"attributes": ids}, unpacked=1000
    )


def test_arrays_come_back_in_the_order_of_the_streams() -> None:
    data = bytes(draco_grid().blob)
    found = decode_streams([stream(STREAMS[0]), draco(data, [3]), stream(STREAMS[-1])])
    assert [sorted(item) for item in found] == [["rows"], ["3", "faces"], ["rows"]]
    assert np.array_equal(found[1]["faces"], DracoPy.decode(data).faces)
    assert found[2]["rows"].shape == (STREAMS[-1][2], STREAMS[-1][3])


def test_the_stream_that_is_broken_is_named() -> None:
    with pytest.raises(FormatError, match=r"^bufferView 7: a meshopt stream of attributes"):
        decode_streams([stream(STREAMS[0]), stream(STREAMS[0], count=9999)])
    with pytest.raises(FormatError, match=r"^mesh 1, primitive 2: a Draco stream is damaged"):
        decode_streams([draco(b"DRACO nothing else", [0])])
    with pytest.raises(
        FormatError, match=r"^mesh 1, primitive 2: a Draco stream does not start with its header"
    ):
        decode_streams([draco(b"CARDO nothing else", [0])])


@pytest.mark.parametrize(
    "end", ["import os; os.kill(os.getpid(), 11)", "raise SystemExit(3)", "print(5)", "pass"]
)
def test_a_decoder_that_crashes_is_a_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, end: str
) -> None:
    child = tmp_path / "child.py"
    child.write_text(end)
    monkeypatch.setattr(gltf_streams, "_CHILD", child)
    with pytest.raises(FormatError, match=r"damaged: the decoder ended by (signal 11|exit [03])"):
        decode_streams([stream(STREAMS[0])])


def test_time_is_limited(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    child = tmp_path / "child.py"
    child.write_text("import time; time.sleep(60)")
    monkeypatch.setattr(gltf_streams, "_CHILD", child)
    monkeypatch.setattr(gltf_streams, "_SECONDS", 1)
    with pytest.raises(FormatError, match="takes more than 1 s to decode"):
        decode_streams([stream(STREAMS[0])])


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits the address space")
def test_memory_is_limited() -> None:
    # 100 million equal rows, which take a byte for every 256 of them.
    count = 100_000_000
    data = b"\xa1" + b"\xaa" * -(-count // 256) + bytes(24)
    given = {"mode": "ATTRIBUTES", "filter": "NONE", "count": count, "stride": 4}
    with pytest.raises(FormatError, match="its compressed data needs more than 1 GB to decode"):
        decode_streams(
            [Stream(where="bufferView 0", data=data, codec="meshopt", parameters=given, unpacked=1000)]
        )


def test_what_claims_to_grow_beyond_any_mesh_is_refused() -> None:
    small = Stream(where="bufferView 0", data=bytes(1000), codec="meshopt", parameters={}, unpacked=33 << 20)
    with pytest.raises(FormatError, match=r"1,000 bytes claims to unpack to 34,603,008 bytes"):
        decode_streams([small])
    large = Stream(
        where="bufferView 0", data=bytes(20 << 20), codec="meshopt", parameters={}, unpacked=600 << 20
    )
    with pytest.raises(FormatError, match="unpacks to 600 MB, the most that is read is 160 MB"):
        decode_streams([large])
