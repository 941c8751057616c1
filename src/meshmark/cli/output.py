"""What commands print: answers to standard output, everything else to standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from meshmark.cli.listening import listener

if TYPE_CHECKING:
    from meshmark.coding.keys import Key

__all__ = ["answer", "described", "percent", "plural", "printable", "say"]


def answer(lines: str, fields: Mapping[str, Any], as_json: bool) -> None:
    """Print the result of a command: as one JSON object, or as plain words."""
    heard = listener()
    if heard is not None:
        heard.answer(lines, fields)
    elif as_json:
        print(json.dumps(fields, allow_nan=False))
    else:
        print("\n".join(printable(line) for line in lines.splitlines()))


def described(
    fields: Mapping[str, Any],
    source: Path | Sequence[Path] | None = None,
    outputs: Mapping[str, Path | None] | None = None,
    key: Key | None = None,
) -> dict[str, Any]:
    """Return the fields of an answer after those that every JSON answer has.

    source: the model or models read. outputs: the files written, by what they are; None for one that was not. key:
    named by its public fingerprint.
    """
    from meshmark import __version__

    written = {name: str(path) for name, path in (outputs or {}).items() if path is not None}
    return {
        "version": __version__,
        "input": [str(path) for path in source] if isinstance(source, Sequence) else _text(source),
        "outputs": written,
        "key": None if key is None else key.fingerprint,
        **fields,
    }


def _text(path: Path | None) -> str | None:
    return None if path is None else str(path)


def say(line: str) -> None:
    """Print a remark, a warning or an error: to standard error, whatever the file names hold."""
    heard = listener()
    if heard is not None:
        heard.remark(line)
        return
    print(printable(line), file=sys.stderr, flush=True)


def printable(text: str) -> str:
    """Return text in which control characters and undecodable bytes of file names cannot do harm."""
    shown = "".join(c if c.isprintable() or c == " " else c.encode("unicode_escape").decode() for c in text)
    return shown.encode("utf-8", "backslashreplace").decode()


def percent(share: float) -> str:
    """Return a share as a percentage with two significant digits: 0.00078 is "0.078 %"."""
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def plural(count: int, noun: str) -> str:
    """Return "1 vertex"-like text; nouns that take -es or -ices come as "one/many"."""
    one, _, many = noun.partition("/")
    return f"{count:,} {one if count == 1 else many or one + 's'}"
