"""Orders become command lines that the program takes, and that hold nothing else than was asked for."""

from __future__ import annotations

from pathlib import Path

import pytest

from meshmark.cli.commands import COMMANDS
from meshmark.errors import InputError
from meshmark.web.server.orders import ACTIONS, Action, Order, check_order, command_of


def order(action: Action, **fields) -> Order:
    base = {
        "model": Path("in/ear.glb"),
        "key": Path("/keys/a.key"),
        "certificate": None,
        "original": None,
        "options": {},
    }
    return Order(action=action, **{**base, **fields})


def test_every_action_is_a_command_of_the_command_line():
    assert set(ACTIONS) == set(Action)
    assert {action.value for action in Action} <= set(COMMANDS)


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("ear.glb", "out/ear_marked.glb"),
        ("ear.obj.gz", "out/ear_marked.obj.gz"),
        ("ear.v2.ply", "out/ear.v2_marked.ply"),
        ("scan", "out/scan_marked"),
    ],
)
def test_what_is_written_has_the_extension_of_the_model(name, written):
    assert command_of(order(Action.embed, model=Path("in") / name))[2] == written


def test_a_value_that_looks_like_an_option_is_none():
    line = command_of(order(Action.embed, options={"to": "--force", "id": None, "recompress": ""}))
    assert "--to=--force" in line
    assert "--force" not in line
    assert "--recompress" in line
    assert not [each for each in line if each.startswith("--id")]


def test_references_are_handed_on():
    line = command_of(order(Action.extract, certificate=Path("certificate/c.cert")))
    assert "--certificate=certificate/c.cert" in line


@pytest.mark.parametrize(
    ("wrong", "registry", "sentence"),
    [
        (order(Action.trace), False, "trace needs a registry"),
        (order(Action.unmark), False, "unmark needs the certificate"),
        (order(Action.embed, original=Path("o.ply")), False, "embed does not take an original"),
        (order(Action.recover, options={"strength": "strong"}), False, "recover does not take 'strength'"),
        (order(Action.embed, options={"to": "Ann"}), False, "this server has none"),
    ],
)
def test_an_order_that_cannot_be_done_is_refused(wrong, registry, sentence):
    with pytest.raises(InputError, match=sentence):
        check_order(wrong, registry)


def test_an_order_that_can_be_done_is_taken():
    entered = order(Action.embed, options={"to": "Ann", "strength": "subtle"})
    assert check_order(entered, registry=True) is None
    assert check_order(order(Action.unmark, certificate=Path("c.cert")), registry=False) is None
