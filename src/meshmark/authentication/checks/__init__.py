"""Checks of the marks of a suspect, and the points that were altered."""
