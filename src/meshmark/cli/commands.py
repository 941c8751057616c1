"""The table of commands, in the order in which `meshmark --help` lists them."""

from __future__ import annotations

from collections.abc import Callable

from meshmark.cli.attack import attack
from meshmark.cli.authenticate import authenticate
from meshmark.cli.compare import compare
from meshmark.cli.demo import demo
from meshmark.cli.embed import embed
from meshmark.cli.extract import extract
from meshmark.cli.info import info
from meshmark.cli.keygen import keygen
from meshmark.cli.recover import recover
from meshmark.cli.saliency import saliency
from meshmark.cli.segment import segment
from meshmark.cli.unmark import unmark
from meshmark.research.cli.bench import bench
from meshmark.research.cli.train import train

__all__ = ["COMMANDS"]

# A command returns its exit code.
COMMANDS: dict[str, Callable[..., int]] = {
    "keygen": keygen,
    "embed": embed,
    "extract": extract,
    "authenticate": authenticate,
    "recover": recover,
    "unmark": unmark,
    "attack": attack,
    "compare": compare,
    "saliency": saliency,
    "segment": segment,
    "info": info,
    "bench": bench,
    "train": train,
    "demo": demo,
}
