"""The authentication layer: mark vertices, their checks, payload and verdict (DESIGN section 7)."""
