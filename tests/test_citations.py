"""Nothing cites what a reader of this repository cannot see: other documents, issues, numbered bars."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.allowed import allowed
from tests.counting import some

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("src", "tests", "docs", "tools", "claims")
SUFFIXES = {".py", ".md", ".txt", ".toml", ".mjs"}
# The development models are data that CONTRIBUTING names; a command may say where they lie.
FOREIGN = re.compile(
    r"\b(?:DESIGN|INTERFACE)\b(?:\.md)?(?: section \d+)?"
    r"|\b(?:ATTACKS|CHANNEL|RIVALS|STYLE|DEPENDENCIES)\.md\b"
    r"|\b[Ii]ssues? #?\d+\b"
    r"|\b[Bb]ars? \d+\b(?! ?%|\.\d|,\d)(?:(?:,| and) \d+\b(?! %))*"
    r"|shared/(?!data\b)\w+|shared/data/(?:\w+/)*\w+\.md"
)
NAMED = re.compile(r"(?<![\w/.-])(?:[\w-]+/)*[\w-]+\.md\b")
# Pages that commands write, by any name, and the names that stand for such pages.
WRITTEN = {"index.md", "report.md", "PAGE.md", "WORDS.md", "page.md", "paper.md"}
# These hold the patterns and planted citations, and what is still to be mended.
EXEMPT = {"test_citations.py", "foreign_citations.txt"}


def citations(text: str) -> list[str]:
    """Return what a text cites that is not in the repository, in order."""
    return [re.sub(r"\s+", " ", match[0]) for match in FOREIGN.finditer(re.sub(r"\n#? *", " ", text))]


def files() -> list[Path]:
    inside = (path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*")))
    every = [*sorted(ROOT.glob("*.md")), *(path for path in inside if path.suffix in SUFFIXES)]
    kept = (path for path in every if path.name not in EXEMPT and "node_modules" not in path.parts)
    return some(kept, least=500)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("A frame (DESIGN section 4; paper eq. 9).", ["DESIGN section 4"]),
        ("a frame (DESIGN\n    section 11)", ["DESIGN section 11"]),
        ("The contract of INTERFACE.md: fields", ["INTERFACE.md"]),
        ("Issue 6 asks; issue #12 too", ["Issue 6", "issue #12"]),
        ("Bars 2 and 10, and bar 5.", ["Bars 2 and 10", "bar 5"]),
        ("| bar 100 % | bar 1.3 times", []),
        ("../shared/data/models and ../shared/STYLE.md", ["shared/STYLE"]),
        ("As ../shared/data/README.md has them", ["shared/data/README.md"]),
        ("a new design, an interface, a tissue 5", []),
    ],
)
def test_citations_are_found(text, expected):
    assert citations(text) == expected


def test_nothing_cites_what_is_not_in_the_repository():
    """The list has a line for each citation: the file's name, and what it cites."""
    found = [
        f"{path.name}: {what}" for path in files() for what in citations(path.read_text(encoding="utf-8"))
    ]
    assert sorted(found) == allowed("foreign_citations")


def test_every_document_that_is_named_is_there():
    known = {path.name for path in files()} | WRITTEN
    found = [
        f"{path.relative_to(ROOT)}: {name}"
        for path in files()
        for name in NAMED.findall(path.read_text(encoding="utf-8"))
        if Path(name).name not in known
    ]
    assert found == []
