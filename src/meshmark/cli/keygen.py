"""`meshmark keygen`: make a secret key."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from meshmark.cli.options import AsJson
from meshmark.cli.output import answer, described

__all__ = ["keygen"]


def keygen(
    keyfile: Annotated[Path, typer.Argument(metavar="KEYFILE", help="New file to keep the key in.")],
    as_json: AsJson = False,
) -> int:
    """Make a secret key.

    It goes to a new file that only you can read, and is never shown. JSON names its public fingerprint.

    Whoever has the key can find and imitate your marks; without it, yours cannot be found again.
    """
    from meshmark.coding.keys import Key

    key = Key.generate()
    key.save(keyfile)
    words = f"New key in {keyfile}. Keep a copy in a safe place: it cannot be made again."
    answer(words, described({}, outputs={"key": keyfile}, key=key), as_json)
    return 0
