"""What every refusal has in common: one sentence, exit code 2, nothing changed."""

from __future__ import annotations

import hashlib
from pathlib import Path


def snapshot(folder: Path) -> dict[str, str]:
    """Return the names of all files below a folder, hidden ones too, and digests of what they hold."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        if path.is_file()
        else "folder"
        for path in folder.rglob("*")
    }


def assert_refused(ran, folder: Path, before: dict[str, str]) -> None:
    """One sentence on standard error, exit code 2, and nothing changed."""
    assert ran.code == 2, ran
    assert ran.out == ""
    lines = ran.err.splitlines()
    assert len(lines) == 1, ran.err
    assert lines[0].startswith("meshmark: ")
    assert len(lines[0]) > 25
    assert "Traceback" not in ran.err
    assert "bug in meshmark" not in ran.err
    assert snapshot(folder) == before
