"""Copies of one mesh in a scene."""

__all__ = ["FIRST_LARGEST"]

FIRST_LARGEST = 0.999
"""Of several copies the first is taken that is at least so many times as large as the largest."""
