"""One model of a batch: the single command's own answer, with --json, in a worker process."""

from __future__ import annotations

import contextlib
import io
import json
import os
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from meshmark.batch.results import Row
from meshmark.batch.sources import Item
from meshmark.errors import MeshmarkError, RegistryError

__all__ = ["CERTIFICATE_SUFFIX", "BatchCommand", "done"]

CERTIFICATE_SUFFIX = ".cert"
"""After the name of a marked file."""


@dataclass(frozen=True, kw_only=True)
class BatchCommand:
    """What is done with each model. name: of the single command; key: its file; out: folder of the results.

    options: of the single command; certificates: are written beside marked files; registry: its place, or None.
    """

    name: str
    key: str
    out: str
    options: tuple[str, ...] = ()
    certificates: bool = False
    registry: str | None = None

    def marked(self, item: Item) -> Path:
        """Return where the marked copy of a model goes."""
        return Path(self.out, item.name)


def done(command: BatchCommand, item: Item) -> Row:
    """Return the row of a model: what the single command says, its exit code, and the digest of the file."""
    row: Row = {"model": item.name, "digest": None, "exit_code": 2}
    try:
        row["digest"] = _digest(item.path)
        words, issued = _line(command, item, row["digest"])
        code, answer = _answer([command.name, str(item.path), *words, "--json"])
        if issued is not None and "error" not in answer:
            _check_issued(command.marked(item), issued)
            answer["recipient"] = item.recipient
    except MeshmarkError as error:
        return {**row, "error": {"kind": error.kind, "message": str(error), "file": error.file}}
    return {**row, "exit_code": code, **answer}


def _digest(path: Path) -> str | None:
    """Return SHA-256 of a file; None where it cannot be read, which the command will say."""
    from meshmark.io.file_digest import digest_of_file

    with contextlib.suppress(OSError):
        return digest_of_file(path)
    return None


def _line(command: BatchCommand, item: Item, digest: str | None) -> tuple[list[str], str | None]:
    """Return the words of a command line after the model.

    And the digest of the marked copy, where a run that ended before it could say so has issued it already: then the
    same file is made once more, for its row.
    """
    words = ["--key", command.key, "--force", *command.options]
    registry = [] if command.registry is None else ["--registry", command.registry]
    if command.name != "embed":
        return [*words, *registry], None
    from meshmark.batch.batch_id import batch_id
    from meshmark.coding.keys import Key
    from meshmark.coding.message import ID_BITS, format_id, parse_id, requested_id

    place = command.marked(item)
    with contextlib.suppress(OSError):  # which the command will say
        place.parent.mkdir(parents=True, exist_ok=True)
    secret = Key.load(command.key, force=True)
    bits = int(dict(pairwise(command.options)).get("--bits", ID_BITS))
    drawn = batch_id(secret, item.name, digest or "", bits) if item.id is None else parse_id(item.id, bits)
    number = requested_id(drawn, bits)
    words = [str(place), *words, *(["--id", format_id(number)] if bits else [])]
    if command.certificates:
        words += ["--certificate", f"{place}{CERTIFICATE_SUFFIX}"]
    issued = (
        None
        if command.registry is None or not bits
        else _issued(command.registry, secret.fingerprint, number, place)
    )
    if issued is not None:
        return words, issued
    return [*words, *registry, *([] if item.recipient is None else ["--to", item.recipient])], None


def _issued(registry: str, key: str, number: int, place: Path) -> str | None:
    """Return the digest of the copy of this id that was issued to this place; None where there is none."""
    from meshmark.cli.registry_option import open_registry
    from meshmark.registry.database_tables import ISSUED

    with open_registry(registry) as opened:
        found = [copy for copy in opened.copies_with_id(number) if copy.key == key]
    there = (copy for copy in found if copy.state == ISSUED and copy.path == os.path.realpath(place))
    return next((copy.marked_digest for copy in there), None)


def _check_issued(place: Path, digest: str) -> None:
    """Raise `RegistryError` where a copy that was made again is another file than was issued."""
    from meshmark.io.file_digest import digest_of_file

    if digest_of_file(place) != digest:
        raise RegistryError(
            f"{place} was issued already, and what is made with its id now is another file; expected the options "
            "and the version of meshmark of then",
            file=place,
        )


def _answer(line: list[str]) -> tuple[int, dict[str, Any]]:
    """Run a command line in this process; returns its exit code and its JSON object."""
    from meshmark.cli.main import main

    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(io.StringIO()):
        code = main(line)
    answer: dict[str, Any] = json.loads(said.getvalue())
    return code, answer
