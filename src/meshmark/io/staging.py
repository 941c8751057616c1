"""Files that take their names together or not at all: complete under temporary names first, then moved.

    with Staging() as staging:
        staging.put(path, data)       # complete and on the disk, but not in its place
        ...                           # an error here, or in any `put`, leaves nothing behind
                                      # the end of the block moves all files into their places

Where a move fails, those made before it are taken back: new files vanish, replaced ones are as they were.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Self

from meshmark.coding.keys import is_key_file
from meshmark.errors import InputError, OutputError

__all__ = ["TEMPORARY", "Staging", "refuse_place"]

_PREFIX, _SUFFIX = ".meshmark.", ".tmp"
TEMPORARY = f"{_PREFIX}*{_SUFFIX}"
"""Names of the folders of files that are not yet in their places; one stays behind where a process is killed."""


class Staging:
    """Files that are to be written by one command or function; use as a context manager.

    replace: existing files may be replaced; keys and the files to keep never are.
    keep: files that are not to be touched, under whatever name: the inputs. like: a file that the others are made
    of: none of them is readable to more users than it is.
    """

    def __init__(self, replace: bool = True, keep: Iterable[Path] = (), like: Path | None = None) -> None:
        self.replace = replace
        self.like = like
        self._kept = list(keep)
        self._folders: dict[Path, Path] = {}
        self._open: set[Path] = set()
        self._staged: dict[Path, Path] = {}
        self._homes: dict[Path, Path] = {}
        self._undo = contextlib.ExitStack()

    @property
    def places(self) -> tuple[Path, ...]:
        """Return where the files go, links resolved."""
        return tuple(self._staged)

    def staged(self, path: Path | str) -> Path:
        """Return the temporary name of a file that was put; raises `KeyError` for others."""
        return self._staged[Path(os.path.realpath(path))]

    def keep(self, *paths: Path) -> None:
        """Add files that are not to be touched."""
        self._kept += paths

    def put(
        self,
        path: Path | str,
        data: bytes,
        home: Path | None = None,
        *,
        move: bool = True,
        like: Path | None = None,
    ) -> Path:
        """Write a file under a temporary name and return that; a link is followed.

        home: folder above `path` that holds the temporary names, in which files refer to each other as in their
        places, and through no link; the file's own folder if None. move: False for a file that has its place
        already, with this content. like: the file that this one is a copy of, or made of, instead of all files'.
        Raises `OutputError` where the file cannot be written or its place is taken, `InputError` where another
        file goes there.
        """
        place = Path(os.path.realpath(path)) if home is None else Path(path)
        try:
            if home is not None:
                refuse_links(place, home)
            if move:
                refuse_place(place, self._kept, self.replace)
                self._refuse_double(place)
            folder = self.folder(place.parent if home is None else home, whole=False)
            staged = folder / place.relative_to(place.parent if home is None else home)
            staged.parent.mkdir(parents=True, exist_ok=True)
            with open(staged, "xb", opener=partial(_opened, like=like or self.like)) as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
        except OSError as error:
            raise _failure(path, error) from None
        if move:
            self._staged[place] = staged
            self._homes[place] = place.parent if home is None else home
        return staged

    def folder(self, home: Path, whole: bool = True) -> Path:
        """Return the temporary folder of the files that go to the existing folder `home`.

        whole: all that will be in it goes there; else what is put only.
        """
        if home not in self._folders:
            try:
                made = tempfile.mkdtemp(prefix=_PREFIX, suffix=_SUFFIX, dir=home)
            except OSError as error:
                raise _failure(home, error) from None
            self._folders[home] = Path(made)
        if whole:
            self._open.add(home)
        return self._folders[home]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self._move()
        finally:
            for folder in self._folders.values():
                shutil.rmtree(folder, ignore_errors=True)

    def _refuse_double(self, place: Path) -> None:
        for other in self._staged:
            if place == other or (place.exists() and other.exists() and place.samefile(other)):
                raise InputError(f"two results are to go to {place}, expected different names", file=place)

    def _move(self) -> None:
        """Move the files into their places, the first one last: it refers to the others."""
        for home in self._open:
            folder = self._folders[home]
            found = [path for path in sorted(folder.rglob("*")) if path.is_file()]
            self._staged |= {home / path.relative_to(folder): path for path in found}
            self._homes |= dict.fromkeys((home / path.relative_to(folder) for path in found), home)
        with self._undo:
            for place, staged in reversed(list(self._staged.items())):
                try:
                    refuse_links(place, self._homes.get(place, place.parent))
                    refuse_place(place, self._kept, self.replace)
                    self._make_folder(place.parent)
                    self._take(place, staged)
                except OSError as error:
                    raise _failure(place, error) from None
            self._undo.pop_all()

    def _make_folder(self, folder: Path) -> None:
        missing = [path for path in (folder, *folder.parents) if not path.exists()]
        for path in reversed(missing):
            path.mkdir()
            self._undo.callback(_quietly, path.rmdir)

    def _take(self, place: Path, staged: Path) -> None:
        if not os.path.lexists(place):
            if self.replace:
                staged.replace(place)
            else:
                _move_new(staged, place)
            self._undo.callback(_quietly, place.unlink)
            return
        old = staged.with_name(f"{staged.name[:80]}.old")
        _copy_aside(place, old)
        self._undo.callback(_quietly, old.replace, place)
        staged.replace(place)


def refuse_links(place: Path, home: Path) -> None:
    """Raise `OutputError` where a folder between `home` and `place`, below it, is a link to another folder."""
    for folder in place.parents:
        if folder == home or not folder.is_relative_to(home):
            return
        if folder.is_symlink():
            raise OutputError(
                f"cannot write {place}: {folder} is a link, expected a folder inside {home}", file=place
            )


def _opened(path: str, flags: int, like: Path | None = None) -> int:
    """Open a new file, with the permissions of another one at most, but its owner's."""
    mode = 0o666
    if like is not None:
        with contextlib.suppress(OSError):
            mode &= like.stat().st_mode | 0o600
    return os.open(path, flags, mode)


def refuse_place(place: Path, kept: Iterable[Path], replace: bool) -> None:
    """Raise `OutputError` where a file must not be written to `place`: see `Staging` for the arguments."""
    if place.is_dir():
        raise OutputError(f"cannot write {place}: it is an existing directory", file=place)
    if not os.path.lexists(place):
        return
    if place.exists() and not place.is_file():
        raise OutputError(
            f"{place} is not an ordinary file, expected the name of a file to write", file=place
        )
    for other in kept:
        if place.exists() and other.exists() and place.samefile(other):
            raise OutputError(
                f"{place} is also an input, which is never overwritten; expected another name", file=place
            )
    if is_key_file(place):
        raise OutputError(f"{place} is a key, which is never overwritten; expected another name", file=place)
    if place.exists() and not replace:
        raise OutputError(
            f"{place} exists already, expected a new name, or --force to replace it", file=place
        )


def _move_new(staged: Path, place: Path) -> None:
    """Move a file to a free name; raises `OutputError` where it was taken meanwhile."""
    try:
        os.link(staged, place)
    except FileExistsError:
        raise OutputError(f"{place} exists already: it was made meanwhile", file=place) from None
    except OSError:  # a file system without hard links
        if os.path.lexists(place):
            raise OutputError(f"{place} exists already: it was made meanwhile", file=place) from None
        staged.replace(place)


def _copy_aside(place: Path, old: Path) -> None:
    try:
        os.link(place, old, follow_symlinks=False)
    except OSError:  # a file system without hard links
        shutil.copy2(place, old, follow_symlinks=False)


def _quietly(call: Callable[..., object], *arguments: object) -> None:
    with contextlib.suppress(OSError):
        call(*arguments)


def _failure(path: Path | str, error: OSError) -> OSError:
    if isinstance(error, OutputError):
        return error
    return OutputError(f"cannot write {path}: {error.strerror or error}", file=path)
