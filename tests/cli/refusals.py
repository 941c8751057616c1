"""What every refusal has in common: one sentence, exit code 2 or 4, nothing changed."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from unittest.mock import ANY


def snapshot(folder: Path) -> dict[str, str]:
    """Return the names of all files below a folder, hidden ones too, and digests of what they hold."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        if path.is_file()
        else "folder"
        for path in folder.rglob("*")
    }


def assert_refused(ran, folder: Path, before: dict[str, str], codes: tuple[int, ...] = (2,)) -> None:
    """One sentence on standard error, with --json the same in an object, an exit code, and nothing changed."""
    assert ran.code in codes, ran
    lines = ran.err.splitlines()
    assert len(lines) == 1, ran.err
    assert lines[0].startswith("meshmark: ")
    assert len(lines[0]) > 25
    assert "Traceback" not in ran.err
    assert "bug in meshmark" not in ran.err
    error = {"kind": ANY, "message": lines[0].removeprefix("meshmark: "), "file": ANY}
    assert (json.loads(ran.out) if ran.as_json else ran.out) == ({"error": error} if ran.as_json else "")
    assert snapshot(folder) == before
