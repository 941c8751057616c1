"""The models of a batch: those of a folder, of a pattern, or of a list."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from meshmark.errors import InputError
from meshmark.io.formats import format_of_name

__all__ = ["Item", "items"]

_COLUMNS = ("path", "id", "recipient")
_WILD = "*?["


@dataclass(frozen=True, kw_only=True)
class Item:
    """One model of a batch. name: its path below the folder of the source, with /, which is also its place in OUT.

    id, recipient: where a table gives them.
    """

    name: str
    path: Path
    id: str | None = None
    recipient: str | None = None


def items(source: str, out: Path) -> Iterator[Item]:
    """Yield the models of a source in the order of their names, or of the list, one at a time.

    Parameters
    ----------
    source : str
        A folder, of which all models are taken, also in folders below; a pattern such as "models/**/*.ply"; a
        model; a text file with a path on each line (# starts a comment); or a CSV table with a column `path`, and
        perhaps `id` and `recipient`. Paths of lists and tables are relative to these.
    out : path
        Folder of the results, of which nothing is taken.

    Yields
    ------
    Item

    Raises
    ------
    InputError
        The source is not there, or a line of it cannot be used.
    """
    place = Path(source)
    if place.is_dir():
        yield from _below(place, place, Path(os.path.realpath(out)))
    elif any(each in source for each in _WILD) and not place.exists():
        yield from _matching(source, Path(os.path.realpath(out)))
    elif not place.is_file():
        raise InputError(f"{source} is not there, expected a folder, a pattern, a model or a list of models")
    elif format_of_name(place) is not None:
        yield Item(name=place.name, path=place)
    elif place.suffix.lower() == ".csv":
        yield from _of_table(place)
    else:
        yield from _of_list(place)


def _below(folder: Path, base: Path, out: Path) -> Iterator[Item]:
    """Yield the models of a folder and of those below, without hidden ones; links to folders are not followed."""
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except OSError as error:
        raise InputError(f"cannot read the folder {folder}: {error.strerror}", file=folder) from None
    for entry in entries:
        path = Path(entry.path)
        if entry.name.startswith("."):
            continue
        if entry.is_dir(follow_symlinks=False):
            if Path(os.path.realpath(path)) != out:
                yield from _below(path, base, out)
        elif entry.is_file() and format_of_name(path) is not None:
            yield Item(name=path.relative_to(base).as_posix(), path=path)


def _matching(pattern: str, out: Path) -> Iterator[Item]:
    parts = Path(pattern).parts
    fixed = next(number for number, part in enumerate(parts) if any(each in part for each in _WILD))
    base = Path(*parts[:fixed])
    found = False
    for path in sorted(base.glob(str(Path(*parts[fixed:])))):
        name = path.relative_to(base)
        hidden = any(part.startswith(".") for part in name.parts)
        if hidden or format_of_name(path) is None or not path.is_file():
            continue
        if not Path(os.path.realpath(path)).is_relative_to(out):
            found = True
            yield Item(name=name.as_posix(), path=path)
    if not found:
        raise InputError(f"{pattern} matches no model, expected a pattern that does")


def _of_list(place: Path) -> Iterator[Item]:
    try:
        with place.open(encoding="utf-8-sig") as file:
            for line in file:
                if text := line.partition("#")[0].strip():
                    yield _named(place, text)
    except UnicodeDecodeError:
        raise InputError(f"{place} is no text, expected a list of models, a path on each line") from None
    except OSError as error:
        raise InputError(f"cannot read {place}: {error.strerror}", file=place) from None


def _of_table(place: Path) -> Iterator[Item]:
    try:
        with place.open(encoding="utf-8-sig", newline="") as file:
            rows = csv.DictReader(file, strict=True)
            if "path" not in (rows.fieldnames or ()):
                raise InputError(f"{place} has no column `path`, expected {', '.join(_COLUMNS)}", file=place)
            for row in rows:
                if not row["path"]:
                    raise InputError(f"{place}, line {rows.line_num}: the column `path` is empty", file=place)
                given = {name: row.get(name) or None for name in ("id", "recipient")}
                yield _named(place, row["path"], **given)
    except UnicodeDecodeError:
        raise InputError(f"{place} is no text, expected a table in UTF-8", file=place) from None
    except csv.Error as error:
        raise InputError(f"{place} is no table: {error}", file=place) from None
    except OSError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot read {place}: {error.strerror}", file=place) from None


def _named(place: Path, text: str, **given: str | None) -> Item:
    """Return the model of a line; outside of the list's folder its name is its whole path."""
    path = place.parent / text
    name = PurePosixPath(os.path.relpath(path, place.parent).replace(os.sep, "/"))
    if ".." in name.parts:
        name = PurePosixPath(*path.resolve().parts[1:])
    return Item(name=str(name), path=path, **given)
