"""The authentication layer: mark vertices, their checks, payload and verdict (docs/design.md, section 7)."""
