"""Damaged files: whatever the bytes, a reader gives a document that keeps its promises or one sentence."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from meshmark.document import Document
from meshmark.errors import InputError
from meshmark.io.formats import detect_format
from tests.counting import Share
from tests.io.binary_samples import binary_ply, binary_stl
from tests.io.text_samples import SAMPLES

GOOD = {name: (sample.suffix, sample.data) for name, sample in SAMPLES.items()}
GOOD |= {
    "ply little": (".ply", binary_ply("<", ("float", "double", "int16"), polygons=True)[0]),
    "ply big with lists": (".ply", binary_ply(">", ("float",) * 3, lists=True)[0]),
    "stl binary": (".stl", binary_stl()),
}
TOKENS = [
    b"0",
    b"-1",
    b"1e308",
    b"-1e-320",
    b"nan",
    b"9" * 30,
    b"\r",
    b"\n",
    b"#",
    b"\\\n",
    b"/",
    b"\0",
    b"\xff",
    b"v",
    b"f 1",
]
rough = st.tuples(st.floats(0, 1), st.integers(0, 12), st.binary(max_size=3) | st.sampled_from(TOKENS))
# Of a file so changed something may well be read.
gentle = st.tuples(st.floats(0, 1), st.just(1), st.sampled_from([b"1", b"7", b"9"]))
edits = st.lists(rough, min_size=1, max_size=4) | st.lists(gentle, min_size=1, max_size=2)


def check(data: bytes, suffix: str, share: Share) -> None:
    """Read; if that succeeds, save unmoved and moved, and read again. Counts what was saved moved."""
    path, sentence = Path("model" + suffix), ""
    share.case()
    try:
        document = detect_format(data, path).parse(data, path)
    except InputError as error:
        document, sentence = None, str(error)
    assert (document is None) == (0 < len(sentence) < 300)
    assert "\n" not in sentence
    if document is not None:
        keeps_its_promises(document, data, path, share)


def keeps_its_promises(document: Document, data: bytes, path: Path, share: Share) -> None:
    assert document.patched(document.vertices, "a") == {"a": data}
    assert np.isfinite(document.vertices).all()
    assert document.faces.min() >= 0
    assert document.faces.max() < len(document.vertices)
    moved = np.clip(document.vertices, -1e300, 1e300) * 1.0000123 + 1e-9
    try:
        conformed = document.conform(moved)
    except InputError:  # beyond the range of the file's numbers
        return
    share.asserted()
    written = document.patched(moved, "a")["a"]
    again = detect_format(written, path).parse(written, path)
    np.testing.assert_array_equal(again.vertices, conformed)
    np.testing.assert_array_equal(again.faces, document.faces)
    np.testing.assert_array_equal(document.conform(conformed), conformed)


@pytest.fixture(scope="module")
def share() -> Iterator[Share]:
    """Of all files together: of one alone it may be few, by chance."""
    with Share(0.03) as share:
        yield share


@pytest.mark.parametrize("name", GOOD)
def test_small_damage(name: str, share: Share) -> None:
    suffix, whole = GOOD[name]

    @settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow], deadline=None)
    @given(changes=edits)
    def damaged(changes: list[tuple[float, int, bytes]]) -> None:
        data = whole
        for place, length, new in changes:
            begin = int(place * len(data))
            data = data[:begin] + new + data[begin + length :]
        check(data, suffix, share)

    damaged()


@pytest.mark.parametrize("name", ["off", "obj", "ply", "stl", "stl binary"])
def test_truncation_at_every_byte(name: str) -> None:
    suffix, data = GOOD[name]
    with Share(0.005) as share:
        for size in {*range(0, len(data), 1 + len(data) // 150), len(data)}:
            check(data[:size], suffix, share)


@settings(max_examples=150, deadline=None)
@given(data=st.binary(max_size=300), suffix=st.sampled_from([".off", ".obj", ".ply", ".stl", ""]))
@example(data=b"OFF\n1 1 1\n", suffix=".off")
@example(data=b"solid" + b"\n" * 20_000, suffix=".stl")
@example(data=b"#" * 20_000, suffix=".obj")
@example(data=b"ply\n" * 5_000, suffix=".ply")
def test_any_bytes(data: bytes, suffix: str) -> None:
    """Hardly any of these is a model: what counts is the sentence, which `check` asserts of each."""
    check(data, suffix, Share(1.0))
