"""Two keys and an id, for tests."""

from __future__ import annotations

from meshmark.coding.keys import Key

KEY, OTHER = Key(bytes(range(32))), Key(bytes(32))
ID = 0x0123456789ABCDEF
