"""Spans of JSON values agree with Python's own parser; a replacement changes nothing else."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.errors import FormatError
from meshmark.io.gltf.json_text import load_json, locate, replace

SCALARS = (
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text()
)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=20
)


def leaves(tree: Any, path: tuple[Any, ...] = ()) -> dict[tuple[Any, ...], Any]:
    if isinstance(tree, dict):
        return {k: v for key, value in tree.items() for k, v in leaves(value, (*path, key)).items()}
    if isinstance(tree, list):
        return {k: v for key, value in enumerate(tree) for k, v in leaves(value, (*path, key)).items()}
    return {path: tree}


@given(VALUES, st.sampled_from([None, 0, 3]), st.booleans())
def test_every_leaf_is_found(tree: Any, indent: int | None, ascii_only: bool) -> None:
    text = json.dumps({"root": tree}, indent=indent, ensure_ascii=ascii_only).encode()
    wanted = leaves({"root": tree})
    spans = locate(text, wanted.keys())
    assert spans.keys() == wanted.keys()
    assert {path: json.loads(text[start:end]) for path, (start, end) in spans.items()} == wanted


@given(st.lists(st.lists(st.integers(), min_size=1), min_size=1), st.data())
def test_replacing_one_number_changes_only_it(tree: list[list[int]], data: st.DataObject) -> None:
    text = json.dumps(tree, indent=1).encode()
    row = data.draw(st.integers(0, len(tree) - 1))
    column = data.draw(st.integers(0, len(tree[row]) - 1))
    span = locate(text, {(row, column)})[row, column]
    tree[row][column] = 12345
    assert replace(text, [(span, b"12345")]) == json.dumps(tree, indent=1).encode()


def test_only_strict_json_is_read() -> None:
    assert load_json(b'\xef\xbb\xbf{"a": [1.50, 1E3]}') == {"a": [1.5, 1000.0]}
    for text in (
        b"{",
        b'{"a":NaN}',
        b'{"a":1,"a":1}',
        b"\xff\xfe{\x00}\x00",
        b'"\xff"',
        b"[" * 10**6,
        b"1" * 10**5,
    ):
        with pytest.raises(FormatError):
            load_json(text)
