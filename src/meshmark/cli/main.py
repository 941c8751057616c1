"""The program `meshmark`: its table of commands, and what becomes of an error."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import traceback
from typing import NoReturn

import typer

from meshmark.cli.commands import COMMANDS
from meshmark.cli.output import say
from meshmark.errors import MeshmarkError

__all__ = ["app", "main", "run"]

# Shells report a program that a closed pipe or Ctrl-C ended as 128 + the number of the signal.
_READER_GONE, _INTERRUPTED = 128 + 13, 128 + 2
_FAILED = 2
_BUGS = (
    "please report it with the command you typed and the output of the same command under MESHMARK_DEBUG=1"
)

app = typer.Typer(
    name="meshmark",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    no_args_is_help=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for _name, _function in COMMANDS.items():
    app.command(_name)(_function)


def _version(asked: bool) -> None:
    if asked:
        from meshmark import __version__

        print(f"meshmark {__version__}")
        raise typer.Exit


@app.callback(epilog="Exit codes: 0 done, or yes; 1 the answer is no; 2 bad usage or input; 3 inconclusive.")
def _root(
    version: bool = typer.Option(
        False, "--version", help="Print the version and exit.", callback=_version, is_eager=True
    ),
) -> None:
    """Put an invisible, key-protected mark into the geometry of a 3D model, and read it back."""


def main(arguments: list[str] | None = None) -> int:
    """Run one command line and return its exit code; nothing but Ctrl-C at odd moments raises."""
    try:
        code = app(arguments, prog_name="meshmark", standalone_mode=False)
        sys.stdout.flush()
        return int(code or 0)
    except MeshmarkError as error:
        return _fail(str(error))
    except typer.TyperException as error:  # a command line that the parser refused
        return _fail(f"{_as_clause(error.format_message())} (see `{_help_for(error)}`)")
    except KeyboardInterrupt:
        return _fail("interrupted", _INTERRUPTED)
    except MemoryError:
        return _fail("there is not enough memory for this model")
    except (BrokenPipeError, SystemExit):  # typer turns a closed pipe into SystemExit
        return _reader_gone()
    except Exception as error:
        if os.environ.get("MESHMARK_DEBUG"):
            traceback.print_exc()
        return _fail(f"this is a bug in meshmark ({type(error).__name__}); {_BUGS}")


def run() -> NoReturn:
    """Run the program on the arguments it was started with, and exit."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a file name need not fit the terminal's encoding
            stream.reconfigure(errors="backslashreplace")
    sys.exit(main())


def _fail(sentence: str, code: int = _FAILED) -> int:
    say(f"meshmark: {' '.join(sentence.split())}")
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
