"""Two keys and two ids, one also as it is written, for tests."""

from __future__ import annotations

from meshmark.coding.keys import Key

KEY, OTHER = Key(bytes(range(32))), Key(bytes(32))
ID = 0x0123456789ABCDEF
IDENTITY = f"{ID:016x}"
OTHER_ID = 0xFEDCBA9876543210
