"""Files that documents and docstrings name are there, under the end of the path that is named."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.counting import some

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("src", "tests", "docs", "tools", "claims")
NAMED = re.compile(r"(?<![\w./*-])(?:[\w-]+/)*[\w-]+\.(?:py|mjs)\b")
# Files that a reader makes, following a guide.
MADE = {"nudge.py"}


def named(text: str) -> list[str]:
    """Return the source files that a text names."""
    return [name for name in NAMED.findall(text) if name not in MADE]


def texts() -> dict[Path, str]:
    """Return the documents, and the modules of the package and of the commands beside it."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    sources = [path for folder in ("src", "claims", "tools") for path in (ROOT / folder).rglob("*.py")]
    return {path: path.read_text(encoding="utf-8") for path in sorted([*pages, *sources])}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("see `cells.py` and ownership/carriers/lock.py.", ["cells.py", "ownership/carriers/lock.py"]),
        ("`io/gltf_*.py`, ../shared/data/a.py, my nudge.py", []),
        ("tools/validate_gltf.mjs", ["tools/validate_gltf.mjs"]),
    ],
)
def test_names_are_found(text, expected):
    assert named(text) == expected


def test_every_source_file_that_is_named_is_there():
    paths = [
        f"/{path.relative_to(ROOT).as_posix()}" for folder in FOLDERS for path in (ROOT / folder).rglob("*")
    ]
    missing = [
        f"{path.relative_to(ROOT)}: {name}"
        for path, text in some(texts().items(), least=300)
        for name in named(text)
        if not any(known.endswith(f"/{name}") for known in paths)
    ]
    assert missing == []
