"""The one object that a command prints with --json."""

from __future__ import annotations

import json
from typing import Any


def only_object(text: str) -> dict[str, Any]:
    """Return the one JSON object that a text consists of; NaN and infinity are not JSON."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is not JSON")

    value = json.loads(text, parse_constant=refuse)
    assert isinstance(value, dict)
    return value
