"""Files that take their names together or not at all."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from meshmark.coding.keys import Key
from meshmark.errors import InputError, OutputError
from meshmark.io import Staging


def contents(folder: Path) -> dict[str, bytes]:
    """Return every file below a folder, hidden ones and links too."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def put_all(files: dict[Path, bytes], then: Callable[[], object] = lambda: None, **options: Any) -> None:
    """Stage files, call `then`, and leave the block."""
    with Staging(**options) as staging:
        for path, data in files.items():
            staging.put(path, data)
        then()


def test_files_appear_at_the_end_of_the_block_and_all_together(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    with Staging() as staging:
        staged = staging.put(tmp_path / "a", b"one")
        staging.put(tmp_path / "other" / "b", b"two")
        assert staged.read_bytes() == b"one"
        assert not (tmp_path / "a").exists()
        assert not (tmp_path / "other" / "b").exists()
        assert staging.places == (tmp_path / "a", tmp_path / "other" / "b")
    assert contents(tmp_path) == {"a": b"one", "other/b": b"two"}
    assert {path.name for path in tmp_path.iterdir()} == {"a", "other"}


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_an_error_in_the_block_leaves_nothing(tmp_path: Path, error: type[BaseException]) -> None:
    (tmp_path / "b").write_bytes(b"older")

    def fail() -> None:
        raise error

    with pytest.raises(error):
        put_all({tmp_path / "a": b"one", tmp_path / "b": b"two"}, fail)
    assert contents(tmp_path) == {"b": b"older"}


def test_a_file_that_does_not_fit_takes_the_others_with_it(tmp_path, monkeypatch) -> None:
    calls = []

    def full(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match=r"cannot write .*b: No space left") as caught:
        put_all({tmp_path / "a": b"one", tmp_path / "b": b"two"})
    assert caught.value.file == str(tmp_path / "b")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("hard_links", [True, False])
def test_a_move_that_fails_takes_earlier_moves_back(tmp_path, monkeypatch, hard_links) -> None:
    (tmp_path / "replaced").write_bytes(b"older")
    if not hard_links:

        def none(*_: object, **__: object) -> None:
            raise OSError(errno.EPERM, os.strerror(errno.EPERM))

        monkeypatch.setattr(os, "link", none)

    # The first one is moved last, and fails.
    files = {tmp_path / "last": b"3", tmp_path / "replaced": b"2", tmp_path / "made": b"1"}

    def put_more() -> None:
        with Staging() as staging:
            for path, data in files.items():
                staging.put(path, data)
            staging.put(tmp_path / "deep" / "file", b"0", home=tmp_path)
            (tmp_path / "last").mkdir()

    with pytest.raises(OutputError, match="is an existing directory"):
        put_more()
    (tmp_path / "last").rmdir()
    assert contents(tmp_path) == {"replaced": b"older"}
    assert [path.name for path in tmp_path.iterdir()] == ["replaced"]


def test_existing_files_are_replaced_only_where_that_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"older")
    with pytest.raises(OutputError, match=r"a exists already, expected a new name, or --force"):
        Staging(replace=False).put(tmp_path / "a", b"new")
    with pytest.raises(OutputError, match="exists already"):
        put_all(
            {tmp_path / "b": b"new"},
            lambda: (tmp_path / "b").write_bytes(b"made meanwhile"),
            replace=False,
        )
    assert contents(tmp_path) == {"a": b"older", "b": b"made meanwhile"}
    with Staging(replace=True) as staging:
        staging.put(tmp_path / "a", b"new")
    assert (tmp_path / "a").read_bytes() == b"new"


def test_inputs_and_keys_are_never_touched_under_whatever_name(tmp_path: Path) -> None:
    (tmp_path / "input").write_bytes(b"input")
    (tmp_path / "soft").symlink_to(tmp_path / "input")
    os.link(tmp_path / "input", tmp_path / "hard")
    Key(bytes(32)).save(tmp_path / "key")
    (tmp_path / "to key").symlink_to(tmp_path / "key")
    before = contents(tmp_path)
    for name in ("input", "soft", "hard"):
        with (
            pytest.raises(OutputError, match="is also an input"),
            Staging(keep=[tmp_path / "input"]) as staging,
        ):
            staging.put(tmp_path / name, b"new")
    for name in ("key", "to key"):
        with pytest.raises(OutputError, match="is a key, which is never overwritten"), Staging() as staging:
            staging.put(tmp_path / name, b"new")
    assert contents(tmp_path) == before


@pytest.mark.parametrize("name", ["a", "same"])
def test_two_files_for_one_place_are_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "a").write_bytes(b"older")
    os.link(tmp_path / "a", tmp_path / "same")

    def put_both() -> None:
        with Staging() as staging:
            for place in ("a", name):
                staging.put(tmp_path / place, b"new")

    with pytest.raises(InputError, match="two results"):
        put_both()
    assert contents(tmp_path) == {"a": b"older", "same": b"older"}


def test_a_whole_folder_is_moved_with_the_modes_of_its_files(tmp_path: Path) -> None:
    (tmp_path / "there").write_bytes(b"there")
    with Staging(replace=False) as staging:
        work = staging.folder(tmp_path)
        (work / "sub").mkdir()
        (work / "sub" / "a").write_bytes(b"a")
        Key(bytes(32)).save(work / "my.key")
    assert (tmp_path / "sub" / "a").read_bytes() == b"a"
    assert (tmp_path / "my.key").stat().st_mode & 0o777 == 0o600
    assert {path.name for path in tmp_path.iterdir()} == {"there", "sub", "my.key"}


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o644, 0o444])
def test_a_result_is_readable_to_no_more_users_than_what_it_is_made_of(tmp_path: Path, mode: int) -> None:
    (tmp_path / "input").write_bytes(b"input")
    (tmp_path / "input").chmod(mode)
    (tmp_path / "side").write_bytes(b"beside")
    (tmp_path / "side").chmod(0o600)
    before = os.umask(0o022)
    try:
        with Staging(like=tmp_path / "input") as staging:
            staging.put(tmp_path / "a", b"new")
            staging.put(tmp_path / "copy", b"new", like=tmp_path / "side")
        with Staging() as staging:
            staging.put(tmp_path / "free", b"new")
    finally:
        os.umask(before)
    expected = (mode | 0o600) & 0o644
    assert {name: (tmp_path / name).stat().st_mode & 0o777 for name in ("a", "copy", "free")} == {
        "a": expected,
        "copy": 0o600,
        "free": 0o644,
    }


def test_nothing_is_written_through_a_link_below_the_folder(tmp_path: Path) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "home" / "sub").symlink_to(tmp_path / "elsewhere")
    home = tmp_path / "home"
    with pytest.raises(OutputError, match="sub is a link, expected a folder inside"), Staging() as staging:
        staging.put(home / "sub" / "buffer.bin", b"new", home)

    def linked_meanwhile() -> None:
        with Staging() as staging:
            staging.put(home / "later" / "buffer.bin", b"new", home)
            (home / "later").symlink_to(tmp_path / "elsewhere")

    with pytest.raises(OutputError, match="later is a link"):
        linked_meanwhile()
    assert list((tmp_path / "elsewhere").iterdir()) == []
