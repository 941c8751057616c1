"""Where words and lines stand, against `str.split` and `str.splitlines`."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.errors import FormatError
from meshmark.io.text import tokens as text_tokens
from meshmark.io.text.tokens import key, token_blocks, tokenise

texts = st.text("ab#\\ \t\n\r", max_size=60)


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_tokens, "_BLOCK", 7)


def words(data: bytes, **options: bool) -> list[list[str]]:
    """Return the words of each line that has any, as the blocks give them."""
    lines = []
    for base, block in token_blocks(data, **options):
        found = [data[a + base : b + base].decode() for a, b in zip(block.starts, block.ends, strict=True)]
        lines += (
            [part.tolist() for part in np.split(np.array(found, dtype=object), block.first[1:])]
            if found
            else []
        )
    return lines


@given(texts)
def test_words_and_lines(text: str) -> None:
    expected = [line.split() for line in text.replace("\r\n", "\n").replace("\r", "\n").split("\n")]
    assert words(text.encode()) == [line for line in expected if line]


# A backslash that ends the file joins nothing.
@given(texts.filter(lambda text: not text.endswith("\\")))
def test_comments_and_joined_lines(text: str) -> None:
    lines, joined = [], ""
    for line in text.replace("\r\n", "\n").replace("\r", "\n").split("\n"):
        plain, comment, _ = line.partition("#")
        if plain.endswith("\\") and not comment:
            joined += plain[:-1] + " "
            continue
        lines.append((joined + plain).split())
        joined = ""
    lines.append(joined.split())
    assert words(text.encode(), comments=True, continued=True) == [line for line in lines if line]


@given(texts)
def test_one_piece_equals_blocks(text: str) -> None:
    data = text.encode()
    tokens = tokenise(data, comments=True)
    found = [data[a:b].decode() for a, b in zip(tokens.starts, tokens.ends, strict=True)]
    split = np.split(np.array(found, dtype=object), tokens.first[1:]) if found else []
    expected = words(data, comments=True)
    assert [line.tolist() for line in split] == expected
    assert tokens.counts().tolist() == [len(line) for line in expected]


def test_keys_tell_words_apart() -> None:
    tokens = tokenise(b"v vt Vertex vertex endfacet endfacets v")
    everything = np.arange(len(tokens.starts))
    assert (tokens.keys(everything) == key(b"v")).nonzero()[0].tolist() == [0, 6]
    assert (tokens.keys(everything, fold=True) == key(b"vertex")).nonzero()[0].tolist() == [2, 3]
    assert (tokens.keys(everything) == key(b"endfacet")).nonzero()[0].tolist() == [4]
    assert tokens.keys(everything)[5] == 0
    assert tokenise(b"v").keys(np.array([0])) == key(b"v")


@pytest.mark.parametrize("data", ["OFF".encode("utf-16"), b"OFF\0"])
def test_what_is_no_text_is_refused(data: bytes) -> None:
    with pytest.raises(FormatError, match=r"UTF-16|zero bytes"):
        tokenise(data)


def test_utf8_mark_is_no_word() -> None:
    assert tokenise(b"\xef\xbb\xbfOFF").word(0) == "OFF"
