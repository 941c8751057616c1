"""Reading typed values out of glTF's JSON tree; whatever is not as expected is named in one sentence."""

from __future__ import annotations

import math
from collections.abc import Sized
from typing import Any

from meshmark.errors import FormatError

__all__ = ["Json", "integer", "numbers", "objects", "reference", "references", "text"]

Json = dict[str, Any]


def objects(parent: Json, key: str, where: str = "the file") -> list[Json]:
    """Return the list of objects `parent[key]`, empty where absent."""
    found = parent.get(key, [])
    if not isinstance(found, list) or not all(isinstance(item, dict) for item in found):
        raise FormatError(f"{where}: {key!r} is not a list of objects")
    return found


def integer(parent: Json, key: str, where: str, default: int | None = None, low: int = 0) -> int:
    """Return the whole number `parent[key]`, at least `low`; a default of None makes it obligatory."""
    found = parent.get(key, default)
    if isinstance(found, float) and found.is_integer():
        found = int(found)
    if not isinstance(found, int) or isinstance(found, bool) or not low <= found < 2**53:
        raise FormatError(f"{where}: {key!r} is {_shown(found)}, expected a whole number of at least {low}")
    return found


def reference(parent: Json, key: str, where: str, table: Sized) -> int | None:
    """Return the index `parent[key]` into a table, or None where absent."""
    if key not in parent:
        return None
    found = integer(parent, key, where)
    if found >= len(table):
        raise FormatError(f"{where}: {key!r} is {found}, expected an index below {len(table)}")
    return found


def references(parent: Json, key: str, where: str, table: Sized) -> list[int]:
    """Return the list of indices `parent[key]` into a table, empty where absent."""
    found = parent.get(key, [])
    if not isinstance(found, list):
        raise FormatError(f"{where}: {key!r} is not a list of indices")
    checked = [reference({key: item}, key, where, table) for item in found]
    return [item for item in checked if item is not None]


def numbers(parent: Json, key: str, where: str, default: list[float]) -> list[float]:
    """Return the list of finite numbers `parent[key]`, as many as the default has."""
    found = parent.get(key, default)
    if not isinstance(found, list) or len(found) != len(default) or not all(map(_is_finite, found)):
        raise FormatError(f"{where}: {key!r} is {_shown(found)}, expected {len(default)} finite numbers")
    return [float(item) for item in found]


def text(parent: Json, key: str, where: str) -> str | None:
    """Return the string `parent[key]`, or None where absent."""
    found = parent.get(key)
    if found is not None and not isinstance(found, str):
        raise FormatError(f"{where}: {key!r} is {_shown(found)}, expected a string")
    return found


def _is_finite(item: Any) -> bool:
    if not isinstance(item, (int, float)) or isinstance(item, bool):
        return False
    try:
        return math.isfinite(item)
    except OverflowError:
        return False


def _shown(item: Any) -> str:
    shown = "absent" if item is None else repr(item)
    return shown if len(shown) <= 60 else shown[:57] + "..."
