"""What a client asks for, as the command line that does it: the table `ACTIONS`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from meshmark.errors import InputError

__all__ = ["ACTIONS", "Action", "Order", "check_order", "command_of"]

OUT = Path("out")


class Action(StrEnum):
    """What can be done with a model: a command of the command line each."""

    embed = "embed"
    extract = "extract"
    authenticate = "authenticate"
    recover = "recover"
    unmark = "unmark"
    trace = "trace"


@dataclass(frozen=True, kw_only=True)
class Order:
    """One job that is asked for; files are relative to the folder of the job, the key file is not.

    options: those of the command line that the client may set, by their names without dashes, None left out.
    """

    action: Action
    model: Path
    key: Path
    certificate: Path | None
    original: Path | None
    options: dict[str, str | None]


@dataclass(frozen=True, kw_only=True)
class Offer:
    """How an action is done.

    lines: the arguments of an order after the model. options: names of those that it takes.
    references: whether a certificate or the original may be given.
    """

    lines: Callable[[Order], list[str]]
    options: tuple[str, ...] = ()
    references: tuple[str, ...] = ()
    needs_certificate: bool = False
    needs_registry: bool = False


def _written(order: Order, kind: str, extension: str | None = None) -> str:
    """Return the place of a file made of the model: with its extensions, or another."""
    name = order.model.name
    stem, dot, ends = name.partition(".") if name.lower().endswith(".gz") else name.rpartition(".")
    if not stem:
        stem, dot, ends = name, "", ""
    return str(OUT / f"{stem}_{kind}{dot + ends if extension is None else extension}")


def _report(order: Order) -> list[str]:
    return [f"--report={_written(order, 'report', '.html')}"]


def _embed(order: Order) -> list[str]:
    certificate = f"--certificate={_written(order, 'marked', '.cert')}"
    return [_written(order, "marked"), certificate, *_report(order)]


def _authenticate(order: Order) -> list[str]:
    return [f"--map={_written(order, 'map', '.ply')}", *_report(order)]


def _recover(order: Order) -> list[str]:
    return [_written(order, "recovered"), *_report(order)]


_REFERENCES = ("certificate", "original")

ACTIONS: dict[Action, Offer] = {
    Action.embed: Offer(
        lines=_embed, options=("id", "bits", "strength", "layers", "tolerance", "recompress", "to")
    ),
    Action.extract: Offer(lines=_report, options=("search", "time-limit"), references=_REFERENCES),
    Action.authenticate: Offer(lines=_authenticate, references=_REFERENCES),
    Action.recover: Offer(lines=_recover, references=("certificate",)),
    Action.unmark: Offer(
        lines=lambda order: [_written(order, "unmarked")],
        references=("certificate",),
        needs_certificate=True,
    ),
    Action.trace: Offer(lines=_report, options=("search", "time-limit"), needs_registry=True),
}


def check_order(order: Order, registry: bool) -> None:
    """Raise `InputError` where an action cannot be done as it is asked for. registry: whether there is one."""
    offer, name = ACTIONS[order.action], order.action.value
    if offer.needs_registry and not registry:
        raise InputError(f"{name} needs a registry, and this server has none")
    if offer.needs_certificate and order.certificate is None:
        raise InputError(f"{name} needs the certificate that was made at embedding")
    given = {option: value for option, value in order.options.items() if value is not None}
    for option in given:
        if option not in offer.options:
            takes = ", ".join(offer.options) or "no options"
            raise InputError(f"{name} does not take '{option}', expected {takes}")
    if "to" in given and not registry:
        raise InputError("a recipient is kept in a registry, and this server has none")
    for reference in _REFERENCES:
        if getattr(order, reference) is not None and reference not in offer.references:
            raise InputError(f"{name} does not take {'an' if reference[0] == 'o' else 'a'} {reference}")


def command_of(order: Order) -> list[str]:
    """Return the command line of an order, to be run in the folder of its job."""
    offer = ACTIONS[order.action]
    options = [
        f"--{option}" if value == "" else f"--{option}={value}"
        for option, value in order.options.items()
        if value is not None
    ]
    references = [
        f"--{reference}={path}"
        for reference in _REFERENCES
        if (path := getattr(order, reference)) is not None
    ]
    lines = [order.action.value, str(order.model), *offer.lines(order), f"--key={order.key}"]
    return [*lines, *references, *options, "--json"]
