"""The files of a command: the outputs are checked before any time is spent, and take their names together."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from meshmark.errors import CapacityError, InputError, OutputError

if TYPE_CHECKING:
    from meshmark.io import Staging

__all__ = ["STANDARD_INPUT", "Output", "check_output", "make_folder", "naming", "staged", "written_beside"]

STANDARD_INPUT = Path("-")
"""How a command line names it."""

Output = tuple[Path | None, str | None]
"""A file to write, None for none, and the only extension that it may have, in lower case; None for any."""


@contextmanager
def naming(*paths: Path) -> Iterator[None]:
    """Name the files in errors about what they hold, unless one of them is named there."""
    try:
        yield
    except (InputError, CapacityError) as error:
        error.file = error.file or str(paths[0])
        if any(path.name in str(error) for path in paths):
            raise
        kind = CapacityError if isinstance(error, CapacityError) else InputError
        names = ", ".join(path.name for path in paths)
        raise kind(f"{names}: {error}", file=error.file) from None


def staged(outputs: Sequence[Output], inputs: Sequence[Path | None], force: bool) -> Staging:
    """Check all outputs of a command and return what takes them; inputs are never written to.

    The first input is the model that the outputs are made of: none is readable to more users than it is.

    Raises `OutputError` where one cannot be written, exists already without `force`, or is an input, and
    `InputError` for a wrong extension or two outputs of one name.
    """
    from meshmark.io import Staging

    given = [(path, suffix) for path, suffix in outputs if path is not None]
    kept = [path for path in inputs if path is not None]
    for path, suffix in given:
        check_output(path, kept, suffix, force)
    places = [os.path.realpath(path) for path, _ in given]
    for number, (path, _) in enumerate(given):
        if places[number] in places[:number]:
            raise InputError(f"two results are to go to {path}, expected different names", file=path)
    model = inputs[0] if inputs else None
    return Staging(force, kept, None if model == STANDARD_INPUT else model)


def written_beside(staging: Staging, outputs: Sequence[Path | None]) -> list[str]:
    """Return the paths of the files that were written beside the outputs: buffers, materials, images."""
    own = {os.path.realpath(path) for path in outputs if path is not None}
    return [str(place) for place in staging.places if str(place) not in own]


def check_output(path: Path, inputs: Iterable[Path], suffix: str | None = None, force: bool = False) -> None:
    """Raise `OutputError` where `path` cannot be written, exists already without `force`, or is an input.

    suffix: the only extension, in lower case, that the file may have; None for any.
    """
    try:
        _check(path, inputs, force)
    except OSError as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(f"cannot write {path}: {error.strerror or error}", file=path) from None
    if suffix is not None and path.suffix.lower() != suffix:
        raise InputError(f"{path} has the extension '{path.suffix}', expected {suffix}", file=path)


def make_folder(path: Path) -> None:
    """Make a folder, and the folders above it; raises `OutputError` where that fails."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {path}: {error.strerror}", file=path) from None


def _check(path: Path, inputs: Iterable[Path], force: bool) -> None:
    from meshmark.io.staging import refuse_place

    if path == STANDARD_INPUT:
        raise OutputError("nothing is written to standard output but answers, expected the name of a file")
    if path.is_dir():
        raise OutputError(f"{path} is a directory, expected the name of a file to write", file=path)
    refuse_place(path, inputs, force)
    place = Path(os.path.realpath(path))  # of a link, the file that it points to
    if not place.parent.is_dir():
        raise OutputError(f"cannot write {path}: the folder {place.parent} does not exist", file=path)
    if not os.access(place.parent, os.W_OK | os.X_OK):
        raise OutputError(
            f"cannot write {path}: no permission to write in the folder {place.parent}", file=path
        )
