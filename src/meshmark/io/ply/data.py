"""The data of a PLY file, as text or binary behind one interface: values at places.

A place is a byte offset in a binary file and the index of a token in a text file.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.binary_data import Type
from meshmark.io.text.numbers import parse_floats, parse_ints
from meshmark.io.text.tokens import Tokens
from meshmark.mesh import IntArray

__all__ = ["PlyData", "TextData"]


class PlyData(Protocol):
    """Values at places from `begin` to `end`."""

    @property
    def begin(self) -> int:
        """Return the first place."""
        ...

    @property
    def end(self) -> int:
        """Return the place after the last."""
        ...

    @property
    def unit(self) -> tuple[str, str]:
        """Return what one place is, and several are, for messages."""
        ...

    @property
    def whole(self) -> bool:
        """Whether the last value is there in full wherever the file may have been cut off."""
        ...

    def width(self, dtype: Type, /) -> int:
        """Return how many places one value takes."""
        ...

    def count(self, place: int, dtype: Type, /) -> int:
        """Return the list length at a place."""
        ...

    def values(self, places: IntArray, dtype: Type) -> NDArray[Any]:
        """Return the (k,) values at ascending places."""
        ...

    def lists(self, places: IntArray, dtype: Type, members: int) -> NDArray[Any]:
        """Return the (k, members) values of lists that begin at ascending places."""
        ...


@dataclass(frozen=True, eq=False, kw_only=True)
class TextData:
    """Data as text."""

    tokens: Tokens
    begin: int = 0
    unit: tuple[str, str] = ("word", "words")

    @property
    def whole(self) -> bool:
        """Whether white space follows the last token: a number cut short has none."""
        return self.tokens.closed

    @property
    def end(self) -> int:
        """Return the number of tokens."""
        return len(self.tokens.starts)

    def width(self, _dtype: Type) -> int:
        """Return 1: every value is one token."""
        return 1

    def count(self, place: int, _dtype: Type) -> int:
        """Return the list length at a place."""
        word = self.tokens.word(place)
        try:
            return int(word)
        except ValueError:
            raise FormatError(
                f"line {self.tokens.line(place)} has '{word}' where a list length is expected"
            ) from None

    def values(self, places: IntArray, dtype: Type) -> NDArray[Any]:
        """Return the (k,) values at ascending places."""
        spans = self.tokens.starts[places], self.tokens.ends[places]
        if dtype.kind == "f":
            return parse_floats(self.tokens.text, *spans, finite=False)
        return parse_ints(self.tokens.text, *spans)

    def lists(self, places: IntArray, dtype: Type, members: int) -> NDArray[Any]:
        """Return the (k, members) values of lists that begin at ascending places."""
        return self.values((places[:, None] + np.arange(members)).ravel(), dtype).reshape(-1, members)
