"""A command that is a group of commands, such as `meshmark registry`."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import typer

__all__ = ["command_group"]


def command_group(name: str, help: str, commands: Mapping[str, Callable[..., int]]) -> typer.Typer:
    """Return the group of these commands, which its help lists in their order."""
    group = typer.Typer(
        name=name,
        help=help,
        add_completion=False,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        no_args_is_help=False,
    )
    for each, function in commands.items():
        group.command(each)(function)
    return group
