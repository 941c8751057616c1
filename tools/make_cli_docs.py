"""Write docs/cli.md from the program's own `--help`; tests/test_docs.py holds the two in step."""

from __future__ import annotations

import contextlib
import io
import os
from pathlib import Path

from meshmark.cli.commands import COMMANDS, GROUPS, find_group
from meshmark.cli.main import main

HOME = Path(__file__).resolve().parents[1] / "docs" / "cli.md"
INTRODUCTION = """# The command line

Made by `make docs` from the program's own help; do not edit.

- `--json` prints exactly one JSON object on standard output; all else goes to standard error.
- Exit codes: 0 done, or the answer is yes; 1 the answer is no; 2 bad usage or bad input; 3 inconclusive; 4 the
  model cannot carry what was asked. 2 and 4 come with one line on standard error, with `--json` with an object too.
- No existing file is replaced without `--force`; inputs and keys never are.
- `MESHMARK_DEBUG=1` in the environment shows the traceback of an unexpected error.
"""


def help_of(*words: str) -> str:
    """Return the help text of the program or of one command, 96 columns wide."""
    out = io.StringIO()
    os.environ |= {"COLUMNS": "100", "TERMINAL_WIDTH": "100"}
    with contextlib.redirect_stdout(out):
        code = main([*words, "--help"])
    if code:
        raise SystemExit(code)
    return "\n".join(line.rstrip() for line in out.getvalue().strip().splitlines())


def pages() -> str:
    """Return the whole page."""
    parts = [f"## meshmark\n\n```\n{help_of()}\n```\n"]
    for name in COMMANDS:
        parts.append(f"## meshmark {name}\n\n```\n{help_of(name)}\n```\n")
        for inner in find_group(name).registered_commands if name in GROUPS else ():
            parts.append(f"### meshmark {name} {inner.name}\n\n```\n{help_of(name, str(inner.name))}\n```\n")
    return "\n".join([INTRODUCTION, *parts])


if __name__ == "__main__":
    HOME.write_text(pages(), encoding="utf-8")
