"""Pure functions on arrays of positions and triangles."""
