"""Attacks on marked models: one small function each, and the table of them."""

from __future__ import annotations

from meshmark.attacks.attack import Attack, Attacked, Given
from meshmark.attacks.chain import Chain, parse_chain
from meshmark.attacks.table import ATTACKS, find_attack

__all__ = ["ATTACKS", "Attack", "Attacked", "Chain", "Given", "find_attack", "parse_chain"]
