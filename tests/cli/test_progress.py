from __future__ import annotations

import io
import subprocess
import sys
import time

import pytest

from meshmark.cli import progress as module
from meshmark.cli.progress import counted, progress


class Screen(io.StringIO):
    """Stands for standard error on a terminal, and keeps all that is written to it."""

    def isatty(self) -> bool:
        return True


def terminal(monkeypatch) -> Screen:
    """Put a terminal in the place of standard error; pytest would take its own back from a fixture."""
    shown = Screen()
    for name in ("NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setattr(sys, "stderr", shown)
    return shown


def wait_for(text: str, screen: Screen) -> None:
    deadline = time.monotonic() + 20.0
    while text not in screen.getvalue() and time.monotonic() < deadline:
        time.sleep(0.01)


def test_long_work_shows_a_bar_that_is_wiped(monkeypatch):
    screen = terminal(monkeypatch)
    monkeypatch.setattr(module, "_PATIENCE", 0.01)
    with progress("looking [for] it"):
        wait_for("looking [for] it", screen)
    shown = screen.getvalue()
    assert "looking [for] it" in shown
    assert shown.rstrip("\r").endswith("\x1b[2K")  # the line is cleared
    assert "\x1b[?25h" in shown  # and the cursor back


def test_an_error_goes_through_and_the_bar_is_wiped(monkeypatch):
    screen = terminal(monkeypatch)
    monkeypatch.setattr(module, "_PATIENCE", 0.0)

    def divide() -> None:
        with progress("dividing"):
            wait_for("dividing", screen)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        divide()
    assert screen.getvalue().rstrip("\r").endswith("\x1b[2K")


def test_quick_work_shows_nothing(monkeypatch):
    screen = terminal(monkeypatch)
    monkeypatch.setattr(module, "_PATIENCE", 60.0)
    with progress("nothing much"):
        pass
    assert screen.getvalue() == ""


def test_a_count_fills_a_bar_on_a_terminal(monkeypatch):
    screen = terminal(monkeypatch)
    monkeypatch.setattr(module, "_REDRAW", 0.0)
    with counted("cases") as told:
        for done in range(1, 31):
            told(done, 30, done // 10)
    shown = screen.getvalue()
    assert "15 of 30 cases, 1 failed, " in shown
    assert "30 of 30 cases, 3 failed, " in shown
    assert shown.rstrip("\r").endswith("\x1b[2K")


def test_a_pipe_gets_a_line_per_hundred_and_one_at_the_end(capsys):
    with counted("cases") as told:
        for done in range(1, 251):
            told(done, 250, 0)
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(",")[0] for line in lines] == [f"{n} of 250 cases" for n in (100, 200, 250)]


def test_a_pipe_gets_no_bar_and_rich_is_not_imported():
    code = (
        "import sys, time\nfrom meshmark.cli import progress\nprogress._PATIENCE = 0.0\n"
        "with progress.progress('hidden'): time.sleep(0.05)\n"
        "assert 'rich.progress' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert (done.stdout, done.stderr) == (b"", b"")
