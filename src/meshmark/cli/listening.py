"""Who hears what a command says where it runs within another program, and not at a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Protocol

__all__ = ["Listener", "heard_by", "listener"]


class Listener(Protocol):
    """Takes what a command would print."""

    def stage(self, label: str) -> None:
        """Take what the command begins to do."""

    def remark(self, line: str) -> None:
        """Take a remark, a warning, or the sentence of an error."""

    def answer(self, words: str, fields: Mapping[str, Any]) -> None:
        """Take the answer, in plain words and as the fields of its JSON object."""


_heard: list[Listener] = []


@contextmanager
def heard_by(one: Listener) -> Iterator[None]:
    """Hand what the commands of this process say to a listener while the block runs; nothing is printed."""
    _heard.append(one)
    try:
        yield
    finally:
        _heard.pop()


def listener() -> Listener | None:
    """Return who listens, None where commands print."""
    return _heard[-1] if _heard else None
