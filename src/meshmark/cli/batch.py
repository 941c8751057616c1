"""`meshmark batch`: the commands for many models. A group of commands."""

from __future__ import annotations

from collections.abc import Callable

from meshmark.cli.batch_commands import batch_authenticate, batch_embed, batch_extract, batch_trace
from meshmark.cli.command_group import command_group

__all__ = ["BATCH_COMMANDS", "batch"]

BATCH_COMMANDS: dict[str, Callable[..., int]] = {
    "embed": batch_embed,
    "extract": batch_extract,
    "authenticate": batch_authenticate,
    "trace": batch_trace,
}
"""In the order in which `meshmark batch --help` lists them."""

batch = command_group(
    "batch",
    "Mark and read many models.\n\n"
    "Each model is worked on by a process of its own, within limits of time and memory: one that crashes or hangs "
    "is one line with an error. What was interrupted, at whatever moment, goes on with --resume.",
    BATCH_COMMANDS,
)
