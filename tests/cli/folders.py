"""Folders in which commands run."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

__all__ = ["enter_copy"]


def enter_copy(folder: Path, to: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Copy the files of a folder, and make the copy the current folder of this test."""
    for path in folder.iterdir():
        shutil.copy(path, to / path.name)  # with its mode: a key is its owner's alone
    monkeypatch.chdir(to)
