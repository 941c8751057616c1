"""The points of a coarse model carry what its cells cannot: they slide along the surface."""
