"""Schemes of other authors, and the field's classics, to measure ours against: one file each (docs/rivals.md)."""
