"""Run the tour of docs/tour.md with a key that is always the same, and put what it prints there and into README.md.

.venv/bin/python tools/make_tour.py

A key of 32 zero bytes takes the place of the one that `keygen` makes, so that the numbers come out again;
tests/test_docs.py runs the tour the same way and compares.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import tempfile
from collections.abc import Iterator
from pathlib import Path

import meshmark as mm
from meshmark.cli.main import main
from meshmark.data import hare_ply

ROOT = Path(__file__).resolve().parents[1]
TOUR, README = ROOT / "docs" / "tour.md", ROOT / "README.md"
SESSION = re.compile(r"```console\n(.*?)```", re.DOTALL)
COMMAND = re.compile(r"^\$ meshmark (.*)\n((?:(?!\$).*\n)*)", re.MULTILINE)


def sessions() -> list[str]:
    """Return the console sessions of the page: the tour, and the story of a leak."""
    return SESSION.findall(TOUR.read_text(encoding="utf-8"))


def session() -> str:
    """Return the tour."""
    return sessions()[0]


def tour(text: str) -> Iterator[tuple[str, str, int, str]]:
    """Yield what `commands` does, in this folder, with the hare in it."""
    Path("hare.ply").write_bytes(hare_ply())
    return commands(text)


def commands(text: str) -> Iterator[tuple[str, str, int, str]]:
    """Yield each command of a session, what the page shows, its exit code and what it prints, in this folder."""
    for command, shown in COMMAND.findall(text):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            code = main(shlex.split(command))
        if command.startswith("keygen"):
            Path("my.key").unlink()
            mm.Key(bytes(32)).save("my.key")
        yield command, shown.strip(), code, out.getvalue().strip()


def run() -> None:
    """Write what the commands of the tour print into both pages."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        found = [(command, shown, printed) for command, shown, _, printed in tour(session())]
    for page in (TOUR, README):
        text = page.read_text(encoding="utf-8")
        for command, shown, printed in found:
            text = text.replace(f"$ meshmark {command}\n{shown}\n", f"$ meshmark {command}\n{printed}\n")
        page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    run()
