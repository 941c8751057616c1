"""`meshmark keygen`: make a secret key."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from meshmark.cli.output import answer
from meshmark.cli.paths import check_output

__all__ = ["keygen"]


def keygen(
    keyfile: Annotated[Path, typer.Argument(metavar="KEYFILE", help="New file to keep the key in.")],
) -> int:
    """Make a secret key.

    It goes to a new file that only you can read, and is never shown.

    Whoever has the key can find and imitate your marks; without it, yours cannot be found again.
    """
    from meshmark.coding.keys import Key

    check_output(keyfile, [])
    Key.generate().save(keyfile)
    answer(f"New key in {keyfile}. Keep a copy in a safe place: it cannot be made again.", {}, as_json=False)
    return 0
