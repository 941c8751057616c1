"""The check of a proof: the seal of its folder, the commitment, the key, and the reading done again."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from meshmark.certificate.certificate import Certificate
from meshmark.coding.chance import in_words
from meshmark.coding.keys import Key
from meshmark.coding.message import parse_id
from meshmark.errors import InputError
from meshmark.io import read_mesh
from meshmark.registry.commitment import Opening, Statement, key_check
from meshmark.registry.known_reading import KnownReading, read_known
from meshmark.registry.proof import CERTIFICATE, CLAIM
from meshmark.registry.sealed_folder import broken_seal

__all__ = ["ProofCheck", "check_proof"]


@dataclass(frozen=True, kw_only=True)
class ProofCheck:
    """What a check says. why_not: in one sentence what does not hold, None where all does; reading: done again."""

    statement: Statement | None
    commitment: str | None
    reading: KnownReading | None
    why_not: str | None

    @property
    def confirmed(self) -> bool:
        """Return whether all holds."""
        return self.why_not is None

    @property
    def sentence(self) -> str:
        """Return the answer in words."""
        if self.statement is None or self.reading is None:
            return f"Not confirmed: {self.why_not}."
        return (
            f"Confirmed: the suspect is made of the copy {self.statement.id}, committed to for "
            f"{self.statement.recipient or 'nobody in particular'} on {self.statement.issued_at}; chance that "
            f"another model reads like this {in_words(self.reading.log10_chance)}. Commitment {self.commitment}."
        )


def check_proof(folder: Path, key: Key) -> ProofCheck:
    """Check the folder that `prove` made, with the key of the project and nothing else.

    Raises `InputError` where the folder is none of a proof, or cannot be read.
    """
    if not (folder / CLAIM).is_file():
        raise InputError(f"{folder} holds no proof, expected a folder with {CLAIM}", file=folder)
    try:
        why_not = broken_seal(folder, key)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read {folder}: {error}", file=folder) from None
    if why_not is not None:
        return ProofCheck(statement=None, commitment=None, reading=None, why_not=why_not)
    claim = json.loads((folder / CLAIM).read_text("ascii"))  # as it was sealed
    statement = Statement(**{entry.name: claim["statement"][entry.name] for entry in fields(Statement)})
    opening = Opening(statement=statement, nonce=claim["nonce"])
    reading = None
    if (why_not := _unopened(opening, claim, key)) is None:
        beside = folder / CERTIFICATE
        certificate = Certificate.load(beside) if beside.is_file() else None
        reading = read_known(read_mesh(folder / claim["suspect"]), key, parse_id(statement.id), certificate)
        why_not = None if reading is not None else "the suspect does not surely carry the id"
    return ProofCheck(statement=statement, commitment=opening.commitment, reading=reading, why_not=why_not)


def _unopened(opening: Opening, claim: dict[str, Any], key: Key) -> str | None:
    statement = opening.statement
    if opening.commitment != claim["commitment"]:
        return "the commitment is not that of the statement"
    if (statement.key, statement.key_check) != (key.fingerprint, key_check(key)):
        return "the commitment was made for another key"
    return None
