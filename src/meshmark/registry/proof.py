"""A folder that shows a third party whose copy a suspect is, and that is checked with the project's key alone.

proof.txt            what is claimed, in plain words, and how to check it
claim.json           the same for programs: statement, nonce and commitment, the reading, versions
certificate.cert     of the copy, with which the suspect is registered
suspect/             the files of the suspect as they were found
pictures             of the suspect, and of the copy as it was issued where its file is at hand
verify.py            opens the commitment with nothing but Python, then repeats the reading with meshmark
manifest.txt, seal.txt   SHA-256 of each file, and a keyed digest of these (`sealed_folder`)
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from meshmark import __version__
from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certificate_fields import read_fields
from meshmark.coding.chance import in_words
from meshmark.coding.keys import Key
from meshmark.coding.message import format_id
from meshmark.errors import InputError, RegistryError
from meshmark.io import input_files
from meshmark.mesh import Mesh
from meshmark.registry.commitment import Opening, Statement, key_check, opening_of
from meshmark.registry.known_reading import KnownReading, read_known
from meshmark.registry.sealed_folder import sealed_files
from meshmark.registry.times import now

if TYPE_CHECKING:
    from meshmark.registry.records import Copy
    from meshmark.registry.registry import Registry

__all__ = ["CERTIFICATE", "CLAIM", "SUSPECT", "Proof", "prove"]

CLAIM: Final = "claim.json"
CERTIFICATE: Final = "certificate.cert"
SUSPECT: Final = "suspect"
_FORMAT: Final = "meshmark proof 1"
_LAYERS = {
    "authentication": "Its authentication marks, which only this key can make, tell the id.",
    "ownership": "Its surface, read where the copy's certificate says that it lies, tells the id.",
}


@dataclass(frozen=True, eq=False, kw_only=True)
class Proof:
    """A folder that shows whose copy a suspect is. files: what goes into it, by names in the folder."""

    opening: Opening
    reading: KnownReading
    files: Mapping[str, bytes]


def prove(
    copy: Copy, suspect: Mesh, path: Path, key: Key, *, registry: Registry, pictures: Mapping[str, bytes]
) -> Proof | None:
    """Return the proof that a suspect is made of a copy; None where it does not surely carry its id.

    path: of the suspect; pictures: PNG files by name.
    Raises `RegistryError` where the copy was not committed to with this key, or not as the registry has it.
    """
    opening = _opened(copy, key)
    text = registry.certificate(copy.id, copy.key)
    certificate = None if text is None else Certificate(**read_fields(text.encode("utf-8")))
    reading = read_known(suspect, key, copy.id, certificate)
    if reading is None:
        return None
    home = path.parent
    found = {f"{SUSPECT}/{_below(each, home)}": each.read_bytes() for each in input_files(suspect)}
    claim = _claim(copy, opening, reading, f"{SUSPECT}/{path.name}")
    files = {
        **found,
        **pictures,
        CLAIM: (json.dumps(claim, indent=1, ensure_ascii=True) + "\n").encode("ascii"),
        "proof.txt": _words(copy, opening, reading, path.name).encode("utf-8"),
        "verify.py": (resources.files("meshmark.registry") / "verify.py").read_bytes(),
    }
    if text is not None:
        files[CERTIFICATE] = text.encode("utf-8")
    return Proof(opening=opening, reading=reading, files=sealed_files(files, key))


def _opened(copy: Copy, key: Key) -> Opening:
    """Return the opening of what was committed to of a copy; raises `RegistryError` where it is not that."""
    if copy.marked_digest is None or copy.issued_at is None or copy.commitment is None:
        raise RegistryError(f"the copy {format_id(copy.id)} was never completed, so nothing was committed to")
    statement = Statement(
        id=format_id(copy.id),
        original_digest=copy.original,
        marked_digest=copy.marked_digest,
        recipient=copy.recipient,
        issued_at=copy.issued_at,
        key=copy.key,
        key_check=key_check(key),
    )
    opening = opening_of(statement, key)
    if opening.commitment != copy.commitment:
        raise RegistryError(
            f"the row of {format_id(copy.id)} was edited since the copy was made: it is not what was committed to"
        )
    return opening


def _claim(copy: Copy, opening: Opening, reading: KnownReading, suspect: str) -> dict[str, Any]:
    return {
        "format": _FORMAT,
        "statement": asdict(opening.statement),
        "nonce": opening.nonce,
        "commitment": opening.commitment,
        "original": copy.original_name,
        "suspect": suspect,
        "reading": asdict(reading),
        "made_at": now(),
        "meshmark": __version__,
        "mark_format": copy.mark_format,
        "issued_with": copy.meshmark,
    }


def _below(path: Path, home: Path) -> str:
    try:
        return path.resolve().relative_to(home.resolve()).as_posix()
    except ValueError:
        raise InputError(
            f"{path} belongs to the suspect, but lies outside its folder, expected it below {home}", file=path
        ) from None


def _words(copy: Copy, opening: Opening, reading: KnownReading, suspect: str) -> str:
    who = (
        "a copy for which no recipient was named"
        if copy.recipient is None
        else f"the copy of {copy.recipient}"
    )
    return f"""Whose copy is {suspect}?

It is made of {who}: id {format_id(copy.id)}, a copy of {copy.original_name}.

1. What was committed to. On {copy.issued_at} (by the clock of the machine that made the copy) the owner
   committed to this: the id {format_id(copy.id)} is that of {who}; the original has the digest
   {copy.original},
   the copy
   {opening.statement.marked_digest}.
   The commitment, which could be published then and told nothing, is
   {opening.commitment}.
   It is opened by claim.json: SHA-256 of nonce and statement. Nobody can open it as another statement. That it was
   made then is shown by where it was published, not by this folder.

2. What the suspect says. {_LAYERS[reading.layer]}
   The chance that a model which is not made of this copy reads like this: {in_words(reading.log10_chance)}.
   One id was looked for, the one that was committed to; all ways in which it was looked for are counted.

3. How to check. With meshmark {__version__} and the key of this project:

       python verify.py PROJECT.key        or        meshmark registry verify . --key PROJECT.key

   Neither the registry nor any other key is needed. If a byte of this folder is changed, it does not confirm.
"""
