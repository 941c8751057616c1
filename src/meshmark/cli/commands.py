"""The table of commands, in the order in which `meshmark --help` lists them.

A command is imported when it is asked for, by its own name or by its help: `meshmark --help` needs the table only.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

from meshmark.errors import InputError

if TYPE_CHECKING:
    from typer import Typer

__all__ = ["COMMANDS", "ENTRY_POINTS", "GROUPS", "find_command", "find_group"]

ENTRY_POINTS = "meshmark.commands"
"""The group of entry points under which the other wheels, such as meshmark-research, register their commands."""

# What each command does: the first line of its docstring.
COMMANDS: dict[str, str] = {
    "keygen": "Make a secret key.",
    "embed": "Put a mark into a model.",
    "extract": "Look for a mark, by the key alone or with a reference.",
    "authenticate": "Say whether, and where, a model was changed since marking.",
    "recover": "Bring back what was altered in a marked model.",
    "unmark": "Take a mark off again, with the key and the certificate.",
    "trace": "Say whose copy a model is, by the registry of copies.",
    "registry": "Keep who got which copy.",
    "batch": "Mark and read many models.",
    "attack": "Simulate common edits and attacks.",
    "compare": "Measure how far apart two models are.",
    "saliency": "Find where a surface stands out.",
    "segment": "Split a model into regions.",
    "info": "Tell what a file holds.",
    "bench": "Measure schemes on models under attacks.",
    "train": "Train one of the networks: demodulator or distortion.",
    "serve": "Serve the page on which models are marked and checked.",
    "demo": "Show the whole way on one model.",
}
GROUPS = ("registry", "batch")
"""Commands that are groups of commands: what is found by their name is a `typer.Typer`."""
# Commands that come with another wheel, and the extra that installs it.
EXTRAS = {
    "bench": "research",
    "train": "research",
    "serve": "web",
    "registry": "registry",
    "trace": "registry",
}


def find_group(name: str) -> Typer:
    """Return the commands of a group.

    Raises `InputError` for a group of another wheel where that is not installed.
    """
    group: Typer = _loaded(name)
    return group


def find_command(name: str) -> Callable[..., int]:
    """Return the function of a command, which returns its exit code.

    Raises `InputError` for a command of another wheel where that is not installed.
    """
    command: Callable[..., int] = _loaded(name)
    return command


def _loaded(name: str) -> Any:
    if name not in EXTRAS:
        return getattr(import_module(f"meshmark.cli.{name}"), name)
    from importlib.metadata import entry_points

    for point in entry_points(group=ENTRY_POINTS, name=name):
        return point.load()
    raise InputError(
        f"`meshmark {name}` is not part of this installation, get it with: pip install meshmark[{EXTRAS[name]}]"
    )
