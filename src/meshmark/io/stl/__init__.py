"""STL, binary or as text."""
