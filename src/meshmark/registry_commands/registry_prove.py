"""`meshmark registry prove` and `verify`: a folder that shows a third party whose copy a suspect is."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.model_input import read_model
from meshmark.cli.options import AsJson, ForceKey, KeyFile
from meshmark.cli.output import answer, described
from meshmark.cli.paths import make_folder, naming
from meshmark.cli.progress import progress
from meshmark.cli.registry_option import RegistryIn, open_registry, registry_class
from meshmark.errors import InputError, MeshmarkError, OutputError

if TYPE_CHECKING:
    from meshmark.registry.records import Copy

__all__ = ["prove_copy", "verify_proof"]


def prove_copy(
    *,
    identity: Annotated[str, typer.Argument(metavar="ID", help="Of the copy: 16 hexadecimal digits, or 8.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="New or empty folder for the proof.")],
    key: KeyFile,
    suspect: Annotated[
        Path | None,
        typer.Option(
            metavar="MODEL", help="The file that was found; without it, the copy where it was issued."
        ),
    ] = None,
    registry: RegistryIn = None,
    force: ForceKey = False,
    as_json: AsJson = False,
) -> int:
    """Write a folder that shows a third party whose copy a suspect is.

    It holds what was committed to when the copy was made, the suspect, the reading with its bound in plain words,
    pictures, and how to check all of it with the key of the project alone: hand out a key that was derived for this
    project (`meshmark keygen --from`), never the master key.

    Exit code 1: the suspect does not surely carry the id, and nothing is written.
    """
    from meshmark.coding.keys import Key
    from meshmark.coding.message import parse_id
    from meshmark.io import Staging

    number, secret = parse_id(identity), Key.load(key, force=force)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise OutputError(f"{out} exists already, expected a new or an empty folder", file=out)
    with open_registry(registry) as opened, progress("proving"):
        rows = opened.copies_with_id(number, secret.fingerprint)
        if not rows:
            raise InputError(f"the registry has no copy with the id {identity.lower()} and this key")
        path = _suspect(suspect, rows[0])
        mesh = read_model(path, None)
        from meshmark.registry.proof import prove

        with naming(path):
            drawn = _pictures(path, rows[0])
            proof = prove(rows[0], mesh, path, secret, registry=opened, pictures=drawn)
    if proof is None:
        refused = described({"confirmed": False, "id": identity.lower()}, path, key=secret)
        answer(f"{path} does not surely carry the id {identity.lower()}.", refused, as_json)
        return 1
    make_folder(out)
    with Staging(replace=False, keep=[path]) as staging:
        for name, data in proof.files.items():
            staging.put(out / name, data, home=out)
    fields = {
        "confirmed": True,
        "id": identity.lower(),
        "recipient": rows[0].recipient,
        "commitment": proof.opening.commitment,
        "log10_false_accusation": proof.reading.log10_chance,
        "method": proof.reading.layer,
    }
    whose = rows[0].recipient or "nobody in particular"
    words = f"Proof in {out}: {path} is made of the copy of {whose}. See proof.txt."
    answer(words, described(fields, path, {"folder": out}, secret), as_json)
    return 0


def verify_proof(
    *,
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder that `registry prove` made.")],
    key: KeyFile,
    force: ForceKey = False,
    as_json: AsJson = False,
) -> int:
    """Check a proof with the key of the project, without the registry.

    The seal of the folder, the commitment and the key are checked, and the suspect is read again.

    Exit code 0: confirmed; 1: not.
    """
    registry_class()  # says what to install where it is not
    from meshmark.coding.keys import Key
    from meshmark.registry.proof_check import check_proof

    secret = Key.load(key, force=force)
    with progress("checking"):
        found = check_proof(folder, secret)
    statement, reading = found.statement, found.reading
    fields = {
        "confirmed": found.confirmed,
        "why_not": found.why_not,
        "id": None if statement is None else statement.id,
        "recipient": None if statement is None else statement.recipient,
        "issued_at": None if statement is None else statement.issued_at,
        "commitment": found.commitment,
        "log10_false_accusation": None if reading is None else reading.log10_chance,
    }
    answer(found.sentence, described(fields, folder, key=secret), as_json)
    return 0 if found.confirmed else 1


def _suspect(suspect: Path | None, row: Copy) -> Path:
    """Return the file to read: the one that was found, else the copy as it was issued."""
    if suspect is not None:
        return suspect
    path = _issued(row)
    if path is None:
        raise InputError(
            f"the copy is not at {row.path} any more, expected --suspect with the file that was found",
            file=row.path,
        )
    return path


def _issued(row: Copy) -> Path | None:
    """Return the file of the copy where it is at hand; a name without a place could be any file's."""
    path = None if row.path is None else Path(row.path)
    return path if path is not None and path.is_absolute() and path.is_file() else None


def _pictures(path: Path, row: Copy) -> dict[str, bytes]:
    """Return pictures of the suspect, and of the copy as it was issued where its file is at hand."""
    pictures = {"suspect.png": _picture(path, "suspect")}
    with suppress(MeshmarkError):
        if (issued := _issued(row)) is not None:
            pictures["copy.png"] = _picture(issued, "the copy as it was issued")
    return pictures


def _picture(path: Path, caption: str) -> bytes:
    import tempfile

    from meshmark.report.own_colours import own_panel
    from meshmark.report.picture import panels

    mesh = read_model(path, None)
    with tempfile.TemporaryDirectory() as folder:
        panels((own_panel(mesh, caption),), Path(folder) / "picture.png", size=_SIZE)
        return (Path(folder) / "picture.png").read_bytes()


_SIZE = 700
