"""`meshmark keygen`: make a secret key."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from meshmark.cli.options import AsJson, ForceKey
from meshmark.cli.output import answer, described
from meshmark.errors import InputError

__all__ = ["keygen"]


def keygen(
    keyfile: Annotated[Path, typer.Argument(metavar="KEYFILE", help="New file to keep the key in.")],
    master: Annotated[
        Path | None,
        typer.Option("--from", metavar="MASTER", help="Derive the key from this one, by its --label."),
    ] = None,
    label: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="What the derived key is for: the same name gives the same key."),
    ] = None,
    force: ForceKey = False,
    as_json: AsJson = False,
) -> int:
    """Make a secret key.

    It goes to a new file that only you can read, and is never shown. JSON names its public fingerprint.

    Whoever has the key can find and imitate your marks; without it, yours cannot be found again. A key that is
    derived with --from and --label can be handed to an expert for one model or one customer: it gives away neither
    the master key nor the keys of other labels.
    """
    from meshmark.coding.keys import Key

    if (master is None) != (label is None):
        raise InputError("--from and --label belong together, expected both or neither")
    if master is None or label is None:
        key = Key.generate()
        words = f"New key in {keyfile}. Keep a copy in a safe place: it cannot be made again."
    else:
        key = Key.load(master, force=force).derived(label)
        words = f"Key for {label!r} in {keyfile}. {master} and the label make it again."
    key.save(keyfile)
    answer(words, described({"label": label}, master, {"key": keyfile}, key), as_json)
    return 0
