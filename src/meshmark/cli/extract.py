"""`meshmark extract`: look for a mark."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.options import AsJson, KeyFile, ModelIn, Search
from meshmark.cli.output import answer
from meshmark.cli.progress import progress

if TYPE_CHECKING:
    from meshmark.schemes.ncdg_lv import Extraction

__all__ = ["EXIT_CODES", "extract", "found_in_words"]

EXIT_CODES = {"present": 0, "absent": 1, "inconclusive": 3}


def extract(
    model: ModelIn,
    key: KeyFile,
    search: Annotated[
        Search, typer.Option(help="quick is fast; wide spends more time on hard cases, such as crops.")
    ] = Search.quick,
    as_json: AsJson = False,
) -> int:
    """Look for a mark in IN with the key alone; neither the original nor the id is needed.

    Exit code 0: present, and the id is printed; 1: absent; 3: inconclusive.
    """
    from meshmark.coding.keys import Key
    from meshmark.io import read_mesh
    from meshmark.schemes.ncdg_lv import extract as find

    secret = Key.load(key)
    mesh = read_mesh(model)
    with progress("looking for the mark"):
        found = find(mesh, secret, search=search.value)
    answer(found_in_words(found, str(model)), found.to_dict(), as_json)
    return EXIT_CODES[found.presence]


def found_in_words(found: Extraction, name: str) -> str:
    """Return the answer to "whose is it?" in plain words."""
    chance = f"the chance of a false alarm is below 10^{found.log10_false_positive:.0f}"
    lines = {
        "present": f"Present: {name} carries the id {found.to_dict()['id']}; {chance}",
        "absent": f"Absent: no mark of this key was found in {name}",
        "inconclusive": f"Inconclusive: {name} may carry a mark of this key, but it is not certain",
    }[found.presence]
    return f"{lines}\n{found.advice}" if found.advice else lines
