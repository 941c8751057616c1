"""Commitments: opened by what was committed to, and by nothing else."""

from __future__ import annotations

from dataclasses import fields, replace
from hashlib import sha256

import pytest

from meshmark.registry.commitment import Opening, Statement, key_check, opening_of
from tests.keys import IDENTITY, KEY, OTHER

STATEMENT = Statement(
    id=IDENTITY,
    original_digest="a" * 64,
    marked_digest="b" * 64,
    recipient="Zoë",
    issued_at="2026-11-29T12:00:00Z",
    key=KEY.fingerprint,
    key_check=key_check(KEY),
)


def test_the_commitment_is_what_its_definition_says():
    opening = opening_of(STATEMENT, KEY)
    text = (
        '{"format":"meshmark commitment 1","id":"0123456789abcdef","issued_at":"2026-11-29T12:00:00Z",'
        f'"key":"{KEY.fingerprint}","key_check":"{key_check(KEY)}","marked_digest":"{"b" * 64}",'
        f'"original_digest":"{"a" * 64}","recipient":"Zo\\u00eb"}}'
    )
    assert opening.commitment == sha256(bytes.fromhex(opening.nonce) + text.encode()).hexdigest()


@pytest.mark.parametrize("name", [entry.name for entry in fields(Statement)])
def test_no_other_statement_opens_it(name):
    opening = opening_of(STATEMENT, KEY)
    other = replace(STATEMENT, **{name: "c" * 64})
    assert Opening(statement=other, nonce=opening.nonce).commitment != opening.commitment
    assert opening_of(other, KEY).nonce != opening.nonce


def test_nobody_without_the_key_makes_the_nonce():
    assert opening_of(STATEMENT, OTHER).nonce != opening_of(STATEMENT, KEY).nonce
    assert key_check(OTHER) != key_check(KEY)


def test_a_recipient_called_nothing_is_not_nobody():
    nobody = opening_of(replace(STATEMENT, recipient=None), KEY)
    assert nobody.commitment != opening_of(replace(STATEMENT, recipient="null"), KEY).commitment
