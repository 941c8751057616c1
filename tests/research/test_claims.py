"""Every measurement is listed, described, and says which page quotes it."""

from __future__ import annotations

import ast
import re
import subprocess
from pathlib import Path

import pytest

from claims import __main__ as program
from claims.__main__ import ALONE, COMMANDS
from tests.counting import some

ROOT = Path(__file__).parents[2]
PAGE = "docs/claims.md"
TABLE = (ROOT / PAGE).read_text(encoding="utf-8")


def source(name: str) -> str:
    folder = ROOT / "claims"
    path = folder / f"{name}.py"
    return (path if path.exists() else folder / name / "__main__.py").read_text(encoding="utf-8")


def test_every_command_is_listed():
    folder = ROOT / "claims"
    alone = {path.stem for path in folder.glob("*.py") if '__name__ == "__main__"' in path.read_text()}
    packages = {path.parent.name for path in folder.glob("*/__main__.py")}
    assert (alone | packages) - {"__main__"} == set(COMMANDS)
    assert set(COMMANDS) >= ALONE


@pytest.mark.parametrize(("name", "page"), COMMANDS.items())
def test_a_command_says_which_page_quotes_it_and_that_page_names_it(name, page):
    assert page in (ast.get_docstring(ast.parse(source(name))) or "")
    assert name in (ROOT / page).read_text(encoding="utf-8")


def test_the_page_describes_every_command_and_no_other():
    rows = re.findall(r"^\| `(\w+)[^|]*\| [^|]+ \| ([^|]+) \|$", TABLE, re.MULTILINE)
    assert {name for name, _ in rows} == set(COMMANDS)
    assert all(time.strip() for _, time in some(rows))


def test_all_run_in_processes_of_their_own_and_a_missed_bar_is_named(monkeypatch, capsys):
    ran: list[str] = []

    def run(words: list[str], check: bool) -> subprocess.CompletedProcess[str]:
        assert not check
        ran.append(words[-1])
        return subprocess.CompletedProcess(words, int(words[-1] == "claims.code"))

    monkeypatch.setattr(subprocess, "run", run)
    assert program.main([]) == 1
    assert ran == [f"claims.{name}" for name in COMMANDS if name not in ALONE]
    assert "missed a bar: code" in capsys.readouterr().out


def test_the_list_names_every_command_and_runs_none(monkeypatch, capsys):
    monkeypatch.setattr(subprocess, "run", None)
    assert program.main(["--list"]) == 0
    listed = capsys.readouterr().out
    assert [name for name in some(COMMANDS) if f"claims.{name} " not in listed] == []
