"""Two keys and an id, as a number and as it is written, for tests."""

from __future__ import annotations

from meshmark.coding.keys import Key

KEY, OTHER = Key(bytes(range(32))), Key(bytes(32))
ID = 0x0123456789ABCDEF
IDENTITY = f"{ID:016x}"
