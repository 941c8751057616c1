"""What every text format promises: a save replaces coordinates and not one other byte."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from meshmark.document import Document
from meshmark.io import FORMATS
from meshmark.io.formats import detect_format
from tests.io.text_samples import SAMPLES, Sample


def parse(data: bytes, suffix: str) -> Document:
    path = Path("model" + suffix)
    return detect_format(data, path).parse(data, path)


@pytest.fixture(params=SAMPLES)
def sample(request: pytest.FixtureRequest) -> Sample:
    return SAMPLES[request.param]


def test_coordinates_are_read_as_written(sample: Sample) -> None:
    document = parse(sample.data, sample.suffix)
    np.testing.assert_array_equal(document.vertices, sample.positions(sample.numbers))
    assert len(document.faces) == sample.faces
    assert FORMATS[document.format].extensions[0] == sample.suffix


def test_unmoved_save_gives_the_same_bytes(sample: Sample) -> None:
    document = parse(sample.data, sample.suffix)
    assert document.patched(document.vertices.copy(), "name") == {"name": sample.data}
    np.testing.assert_array_equal(document.conform(document.vertices), document.vertices)


def test_moved_save_changes_coordinates_only(sample: Sample) -> None:
    document = parse(sample.data, sample.suffix)
    moved = document.vertices + np.linspace(1e-3, 2e-3, document.vertices.size).reshape(-1, 3)
    written = document.patched(moved, "name")["name"]
    words = sample.read(written)
    conformed = document.conform(moved)
    np.testing.assert_array_equal(sample.positions(words), conformed)
    np.testing.assert_allclose(conformed, moved, rtol=0, atol=0.5e-6)
    again = parse(written, sample.suffix)
    np.testing.assert_array_equal(again.vertices, conformed)
    np.testing.assert_array_equal(again.faces, document.faces)
    np.testing.assert_array_equal(document.conform(conformed), conformed)


def test_rows_that_stay_keep_their_words(sample: Sample) -> None:
    document = parse(sample.data, sample.suffix)
    moved = document.vertices.copy()
    moved[1, 1] += 0.125
    words = sample.read(document.patched(moved, "name")["name"])
    slot = 3 + sample.axes.index(1)
    assert [k for k, (new, old) in enumerate(zip(words, sample.numbers, strict=True)) if new != old] == [slot]
    assert float(words[slot]) == moved[1, 1]


def test_documents_are_left_as_they_were(sample: Sample) -> None:
    document = parse(sample.data, sample.suffix)
    before = document.vertices.copy()
    document.patched(before + 1, "name")
    np.testing.assert_array_equal(document.vertices, before)
    assert document.patched(before, "name")["name"] == sample.data


def test_summary_is_plain_data(sample: Sample) -> None:
    import json

    assert json.dumps(parse(sample.data, sample.suffix).summary())
