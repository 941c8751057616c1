"""The program `meshmark`: its table of commands, and what becomes of an error."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import traceback
from dataclasses import dataclass
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from meshmark.cli.commands import COMMANDS, GROUPS, find_command, find_group
from meshmark.cli.output import answer, say
from meshmark.errors import CapacityError, MeshmarkError

__all__ = ["app", "main", "run"]

# Shells report a program that a closed pipe or Ctrl-C ended as 128 + the number of the signal.
_READER_GONE, _INTERRUPTED = 128 + 13, 128 + 2
_FAILED, _CANNOT_CARRY = 2, 4
_BUGS = (
    "please report it with the command you typed and the output of the same command under MESHMARK_DEBUG=1"
)


class _Commands(TyperGroup):
    """The table of commands; each is imported when it is asked for."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands: dict[str, Any] = dict.fromkeys(COMMANDS)  # the names are what suggestions are made of

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002
        """Return the command of a name, None where there is none."""
        if cmd_name not in COMMANDS:
            return None
        if cmd_name in GROUPS:
            return typer.main.get_command(find_group(cmd_name))
        only = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
        only.command(cmd_name)(find_command(cmd_name))
        return typer.main.get_command(only)

    def format_commands(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002
        """Write the list of commands, from the table."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


app = typer.Typer(
    name="meshmark",
    cls=_Commands,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    no_args_is_help=False,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(asked: bool) -> None:
    if asked:
        from meshmark import __version__

        print(f"meshmark {__version__}")
        raise typer.Exit


@app.callback(
    epilog="Exit codes: 0 done, or yes; 1 the answer is no; 2 bad usage or input; 3 inconclusive; "
    "4 the model cannot carry what was asked."
)
def _root(
    context: typer.Context,
    _: bool = typer.Option(
        False, "--version", help="Print the version and exit.", callback=_version, is_eager=True
    ),
) -> None:
    """Put an invisible, key-protected mark into the geometry of a 3D model, and read it back."""
    if context.invoked_subcommand is None:
        print(context.get_help())


def main(arguments: list[str] | None = None) -> int:
    """Run one command line and return its exit code; nothing but Ctrl-C at odd moments raises."""
    failure = _Failure(_asks_for_json(sys.argv[1:] if arguments is None else arguments))
    try:
        code = app(arguments, prog_name="meshmark", standalone_mode=False)
        sys.stdout.flush()
        return int(code or 0)
    except MeshmarkError as error:
        code = _CANNOT_CARRY if isinstance(error, CapacityError) else _FAILED
        return failure(error.kind, str(error), code, error.file)
    except typer.TyperException as error:  # a command line that the parser refused
        return failure("usage", f"{_as_clause(error.format_message())} (see `{_help_for(error)}`)")
    except KeyboardInterrupt:
        return failure("interrupted", "interrupted", _INTERRUPTED)
    except MemoryError:
        return failure("memory", "there is not enough memory for this model")
    except (BrokenPipeError, SystemExit):  # typer turns a closed pipe into SystemExit
        return _reader_gone()
    except Exception as error:
        if os.environ.get("MESHMARK_DEBUG"):
            traceback.print_exc()
        return failure("bug", f"this is a bug in meshmark ({type(error).__name__}); {_BUGS}")


def run() -> NoReturn:
    """Run the program on the arguments it was started with, and exit."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a file name need not fit the terminal's encoding
            stream.reconfigure(errors="backslashreplace")
    sys.exit(main())


def _asks_for_json(arguments: list[str]) -> bool:
    """Return whether a command line has --json, also one that cannot be parsed."""
    options = arguments[: arguments.index("--")] if "--" in arguments else arguments
    return "--json" in options


@dataclass(frozen=True)
class _Failure:
    """Tells of an error: one sentence on standard error, and with --json an object on standard output."""

    as_json: bool

    def __call__(self, kind: str, sentence: str, code: int = _FAILED, file: str | None = None) -> int:
        message = " ".join(sentence.split())
        if self.as_json:
            try:
                answer("", {"error": {"kind": kind, "message": message, "file": file}}, as_json=True)
                sys.stdout.flush()
            except BrokenPipeError:
                _reader_gone()
        say(f"meshmark: {message}")
        return code


def _help_for(error: typer.TyperException) -> str:
    context = getattr(error, "ctx", None)
    return f"{context.command_path if context else 'meshmark'} --help"


def _as_clause(message: str) -> str:
    message = message.replace("Value error, ", "").rstrip(".")
    return message[:1].lower() + message[1:]


def _reader_gone() -> int:
    """Let the interpreter's last flush go nowhere: who read our output has left."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return _READER_GONE
