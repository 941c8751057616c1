"""How the program starts and how it ends."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from meshmark.cli.commands import COMMANDS, GROUPS, find_command, find_group
from tests.counting import some


def python(code: str, **options):
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False, **options
    )


@pytest.mark.parametrize("line", [["--help"], ["embed", "--help"], ["--version"], ["keygen", "new.key"]])
def test_help_and_keygen_load_nothing_heavy(tmp_path, line):
    heavy = {"numpy", "scipy", "PIL", "rich"}
    ran = python(
        f"import sys; from meshmark.cli.main import main; code = main({line!r});"
        f"print(code, sorted({heavy!r} & sys.modules.keys()), file=sys.stderr)",
        cwd=tmp_path,
    )
    assert ran.stderr == "0 []\n"


def test_a_missing_model_and_a_missing_key_are_told_before_slow_imports(files, tmp_path):
    key = ["--key", str(files.key)]
    sealed = [*key, "--certificate", str(files.model)]
    lines = [
        *([name, "no.ply"] for name in ("info", "saliency", "segment")),
        *([name, "no.ply", *sealed] for name in ("extract", "authenticate")),
        *([name, "no.ply", "out.ply", *sealed] for name in ("recover", "unmark")),
        ["compare", "no.ply", str(files.model)],
        ["extract", str(files.model), "--key", "no.key"],
        ["embed", str(files.model), "out.ply", "--key", "no.key"],
    ]
    ran = python(
        f"import sys; from meshmark.cli.main import main; codes = [main(line) for line in {lines!r}];"
        "print(codes, 'scipy' in sys.modules)",
        cwd=tmp_path,
    )
    assert ran.stdout == f"{[2] * len(lines)} False\n"
    assert len(ran.stderr.splitlines()) == len(lines)
    assert all("cannot read" in told for told in some(ran.stderr.splitlines()))


def test_using_one_scheme_does_not_load_the_others():
    ran = python(
        "import sys, meshmark; meshmark.extract; print('meshmark.research.schemes.table' in sys.modules)"
    )
    assert ran.stdout == "False\n"


def test_import_meshmark_loads_nothing_heavy():
    ran = python("import sys, meshmark; print(sorted({'numpy', 'scipy', 'typer'} & sys.modules.keys()))")
    assert ran.stdout == "[]\n"


def test_python_m_meshmark_is_the_command():
    ran = subprocess.run(
        [sys.executable, "-m", "meshmark", "--version"],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert ran.stdout.startswith("meshmark ")


@pytest.mark.skipif(os.name == "nt", reason="POSIX pipes")
@pytest.mark.parametrize("line", [["--help"], ["info", "--json"]])
def test_a_closed_pipe_ends_the_program_quietly(files, line):
    line = [*line, str(files.model)] if line[0] == "info" else line
    read, write = os.pipe()
    os.close(read)
    ran = subprocess.run(
        [sys.executable, "-m", "meshmark", *line],
        stdout=write,
        stderr=subprocess.PIPE,
        timeout=60,
        check=False,
    )
    os.close(write)
    assert ran.returncode == 141
    assert ran.stderr == b""


def raising(error: BaseException):
    def command(*_: object) -> int:
        raise error

    return command


@pytest.mark.parametrize(
    ("error", "code", "says"),
    [
        (KeyboardInterrupt(), 130, ""),
        (MemoryError(), 2, "not enough memory"),
        (ZeroDivisionError("division by zero"), 2, "bug in meshmark (ZeroDivisionError)"),
        (RuntimeError("secret detail"), 2, "MESHMARK_DEBUG=1"),
    ],
)
def test_unexpected_ends(cli, monkeypatch, files, error, code, says):
    import meshmark.io

    monkeypatch.delenv("MESHMARK_DEBUG", raising=False)
    monkeypatch.setattr(meshmark.io, "read_mesh", raising(error))
    ran = cli("info", files.model)
    assert (ran.code, ran.out) == (code, "")
    assert says in ran.err
    assert len(ran.err.splitlines()) <= 1
    assert "Traceback" not in ran.err
    assert "secret detail" not in ran.err


def test_the_traceback_of_a_bug_is_there_for_who_asks(cli, monkeypatch, files):
    import meshmark.io

    monkeypatch.setenv("MESHMARK_DEBUG", "1")
    monkeypatch.setattr(meshmark.io, "read_mesh", raising(RuntimeError("detail")))
    ran = cli("info", files.model)
    assert ran.code == 2
    assert "RuntimeError: detail" in ran.err


def test_every_command_has_a_one_line_summary_the_first_of_its_docstring():
    for name, summary in some(COMMANDS.items()):
        text = find_group(name).info.help if name in GROUPS else find_command(name).__doc__
        assert (text or "").splitlines()[0] == summary, name
        assert summary.endswith("."), name
        assert len(summary) < 60, name


def test_a_command_is_imported_when_it_is_asked_for():
    ran = python(
        "import sys; from meshmark.cli.main import main; main(['--help']);"
        "print([name for name in sys.modules if name.startswith('meshmark.')], file=sys.stderr)"
    )
    assert "Commands:" in ran.stdout
    assert "meshmark.cli.main" in ran.stderr
    assert "meshmark.cli.embed" not in ran.stderr


@pytest.mark.parametrize(
    ("line", "extra"),
    [
        (["bench", "smoke"], "research"),
        (["train", "--help"], "research"),
        (["trace", "found.obj"], "registry"),
        (["registry", "list"], "registry"),
    ],
)
def test_commands_of_other_wheels_say_how_to_get_them(cli, monkeypatch, line, extra):
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **_: ())
    ran = cli(*line)
    assert (ran.code, ran.out) == (2, "")
    assert ran.err == (
        f"meshmark: `meshmark {line[0]}` is not part of this installation, get it with: "
        f"pip install meshmark[{extra}]\n"
    )
