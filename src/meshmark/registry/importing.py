"""What comes into a registry from a file: checked value by value before anything is written."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Final

from meshmark.coding.message import parse_id
from meshmark.errors import InputError
from meshmark.registry.database_tables import ISSUED, PENDING
from meshmark.registry.records import Copy, MarkedWith, Original
from meshmark.registry.times import check_time, now

__all__ = ["NEEDED", "Incoming", "checked_copy", "checked_original"]

NEEDED: Final = ("id", "key", "original_digest")
"""Fields that every copy has to have."""
_HEX = {"key": 16, "original_digest": 64, "marked_digest": 64, "commitment": 64, "lattice": 32, "digest": 64}


@dataclass(frozen=True, kw_only=True)
class Incoming:
    """A copy that is to come into a registry, its original and its certificate."""

    copy: Copy
    original: Original
    certificate: str | None


def checked_original(values: Mapping[str, Any]) -> Original:
    """Return the original that these fields tell of; raises `InputError` where they do not."""
    descriptor = values.get("descriptor") or None
    try:
        shape = None if descriptor is None else base64.b64decode(str(descriptor), validate=True)
    except ValueError:
        raise InputError("'descriptor' is not base64") from None
    return Original(
        digest=_hex(values, "digest"),
        name=str(values.get("name") or "unknown"),
        points=_whole(values, "points") or 0,
        registered_at=check_time(str(values.get("registered_at") or now())),
        descriptor=shape,
    )


def checked_copy(values: Mapping[str, Any]) -> Copy:
    """Return the copy that these fields tell of, as `Copy.to_dict` names them; raises `InputError` otherwise."""
    state = values.get("state") or ISSUED
    if state not in (PENDING, ISSUED):
        raise InputError(f"'state' is {state!r}, expected {PENDING} or {ISSUED}")
    time = _text(values, "issued_at")
    return Copy(
        id=parse_id(str(values.get("id") or "")),
        key=_hex(values, "key"),
        original=_hex(values, "original_digest"),
        original_name=str(values.get("original") or "unknown"),
        recipient=_text(values, "recipient"),
        path=_text(values, "path"),
        state=state,
        mark=_mark(values),
        mark_format=_whole(values, "mark_format"),
        meshmark=_text(values, "meshmark"),
        issued_at=None if time is None else check_time(time),
        marked_digest=_hex(values, "marked_digest") if values.get("marked_digest") else None,
        commitment=_hex(values, "commitment") if values.get("commitment") else None,
    )


def _mark(values: Mapping[str, Any]) -> MarkedWith | None:
    """Return how the copy is marked, None where no field says so; some of them only are refused."""
    names = [entry.name for entry in fields(MarkedWith)]
    given = [name for name in names if values.get(name) not in (None, "")]
    if not given:
        return None
    if missing := set(names) - set(given):
        raise InputError(f"'{min(missing)}' is missing beside '{given[0]}'")
    return MarkedWith(
        strength=str(values["strength"]),
        layers=str(values["layers"]),
        carriers=str(values["carriers"]),
        lattice=_hex(values, "lattice"),
        spacing=_number(values, "spacing"),
        step=_number(values, "step"),
    )


def _text(values: Mapping[str, Any], name: str) -> str | None:
    value = values.get(name)
    return None if value in (None, "") else str(value)


def _hex(values: Mapping[str, Any], name: str) -> str:
    text, digits = str(values.get(name) or "").lower(), _HEX[name]
    if not re.fullmatch(rf"[0-9a-f]{{{digits}}}", text):
        raise InputError(f"'{name}' is missing or not {digits} hexadecimal digits")
    return text


def _whole(values: Mapping[str, Any], name: str) -> int | None:
    value = values.get(name)
    if value in (None, ""):
        return None
    if not re.fullmatch(r"\d{1,12}", str(value)):
        raise InputError(f"'{name}' is {value!r}, expected a whole number")
    return int(str(value))


def _number(values: Mapping[str, Any], name: str) -> float:
    try:
        number = float(values[name])
    except (TypeError, ValueError):
        number = -1.0
    if not 1e-6 <= number <= 1e3:  # nor is NaN
        raise InputError(f"'{name}' is {values[name]!r}, expected a number above 0")
    return number
