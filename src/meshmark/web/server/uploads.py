"""Uploaded files on the disk: under names that are made here, in the folder of their job."""

from __future__ import annotations

import json
import re
import shutil
import unicodedata
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO
from urllib.parse import unquote

from meshmark.errors import InputError
from meshmark.io.formats import FORMATS, OTHER_NAMES, format_of_name

__all__ = ["clean_name", "model_among", "put_in_places", "stored"]

_LONGEST = 100
_UNWANTED = re.compile(r"[^\w .()+,=@-]")
_EXTENSIONS = (*(end for entry in FORMATS.values() for end in entry.extensions), *OTHER_NAMES, ".zip")
# What a .gltf refers to: no folder deeper, and no file of JSON longer, than this.
_DEEPEST, _MOST_JSON = 4, 64 << 20


def clean_name(name: str) -> str:
    """Return the name of a file in place of one that a client gave: the last part of it, of harmless characters.

    Raises `InputError` where nothing is left.
    """
    last = unicodedata.normalize("NFC", name).replace("\\", "/").rsplit("/", 1)[-1]
    kept = _UNWANTED.sub("_", last).strip(" .-")
    if not kept.strip("_"):
        raise InputError("an uploaded file has no name, expected one with the extension of its format")
    stem, dot, end = kept.partition(".") if len(kept) <= _LONGEST else kept.rpartition(".")
    return kept if len(kept) <= _LONGEST else f"{stem[: _LONGEST - len(dot + end)]}{dot}{end[:20]}"


def stored(stream: BinaryIO, name: str | None, folder: Path) -> Path:
    """Write an upload into a folder and return its path; raises `InputError` where the name is taken or none."""
    path = folder / clean_name(name or "")
    folder.mkdir(exist_ok=True)
    if path.exists():
        raise InputError(f"two of the uploaded files are called {path.name}, expected different names")
    with path.open("xb") as file:
        shutil.copyfileobj(stream, file, 1 << 20)
    return path


def model_among(paths: Sequence[Path]) -> Path:
    """Return the one model among uploaded files; raises `InputError` where there is none or more than one."""
    found = [path for path in paths if _is_model(path)]
    if len(found) > 1:
        names = " and ".join(path.name for path in found[:2])
        raise InputError(
            f"{names} are both models, expected one model, with the files that it refers to",
            file=found[0].name,
        )
    if found:
        return found[0]
    if len(paths) == 1:  # content may tell what the name does not
        return paths[0]
    known = " ".join(_EXTENSIONS)
    raise InputError(f"none of the uploaded files is a model, expected one of {known}, also .gz")


def put_in_places(model: Path, others: Iterable[Path]) -> None:
    """Move files to where the model, a .gltf, says they are below its folder: textures/skin.png.

    A file that the model does not name so stays beside it.
    """
    if model.suffix.lower() != ".gltf":
        return
    wanted = {place.name: place for place in _referred(model)}
    for path in others:
        place = wanted.get(path.name)
        if place is not None and len(place.parts) > 1:
            target = model.parent / place
            target.parent.mkdir(parents=True, exist_ok=True)
            path.rename(target)


def _is_model(path: Path) -> bool:
    return format_of_name(path) is not None or path.suffix.lower() == ".zip"


def _referred(model: Path) -> list[PurePosixPath]:
    """Return the relative places that a .gltf names, each of names that `clean_name` leaves as they are."""
    if model.stat().st_size > _MOST_JSON:
        return []
    try:
        document = json.loads(model.read_bytes())
    except (ValueError, RecursionError):
        return []  # the reader of the format says what is wrong
    entries = [
        entry for key in ("buffers", "images") for entry in _list_of(document, key) if isinstance(entry, dict)
    ]
    places = [PurePosixPath(unquote(entry["uri"])) for entry in entries if isinstance(entry.get("uri"), str)]
    return [place for place in places if len(place.parts) <= _DEEPEST and all(map(_is_clean, place.parts))]


def _list_of(document: Any, key: str) -> list[Any]:
    found = document.get(key) if isinstance(document, dict) else None
    return found if isinstance(found, list) else []


def _is_clean(part: str) -> bool:
    try:
        return clean_name(part) == part
    except InputError:
        return False
